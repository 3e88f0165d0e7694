// Cloths, threads and soft solids on meshes that are sharper than their nodes are apart: what holds them are the mesh's nodes and
// edges.
#include <gtest/gtest.h>

#include <cmath>
#include <sstream>

#include "collide/triangle_contacts.hpp"
#include "collide/triangle_crossing.hpp"
#include "collide/triangle_distance.hpp"
#include "scene/scene_text.hpp"
#include "small_worlds.hpp"
#include "world/shape_library.hpp"

namespace unibody::small_worlds::surface_on_mesh_test {

namespace {

constexpr double height = 0.6, radius = 0.01;  // m, of what stands there and of nodes
const Vec3 tip(0, 0, height);

const std::string solver = "solver: {name: accelerated_jacobi, iterations: 200}\n";

// A pyramid over a square of half-width w (m) in the plane z = 0. Of two sides: its base is turned inwards.
std::string pyramid(double w, bool two_sides = false) {
  std::ostringstream text;
  for (const auto& [x, y] : {std::pair(-w, -w), {w, -w}, {w, w}, {-w, w}}) text << "v " << x << ' ' << y << " 0\n";
  text << "v 0 0 " << height << "\nf " << (two_sides ? "1 2 3 4" : "1 4 3 2") << "\nf 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\n";
  return text.str();
}

// Its ridge lies along y.
std::string roof(double length) {
  std::ostringstream text;
  for (const double y : {-length / 2, length / 2}) text << "v -0.05 " << y << " 0\nv 0.05 " << y << " 0\nv 0 " << y << " 0.6\n";
  text << "f 1 2 3\nf 4 6 5\nf 1 3 6 4\nf 2 5 6 3\nf 1 4 5 2\n";
  return text.str();
}

// Body 0 is a mesh at the origin.
class OnMesh {
 public:
  OnMesh(const std::string& obj, const std::string& motion, const std::string& rest) : OnMesh(TextFile(obj), motion, rest) {}

  Experiment run;

  // How many edges of the one go through faces of the other.
  int crossings() {
    const BodyState place = run.state(0);
    std::vector<Vec3> nodes;
    for (const Vec3& x : mesh().nodes) nodes.emplace_back(place.position + place.orientation * x);
    int count = 0;
    for (const TriangleNodes& x : faces())
      for (const auto& t : mesh().triangles) {
        TriangleNodes y;
        for (std::size_t k = 0; k < 3; ++k) y[k] = nodes[static_cast<std::size_t>(t.nodes[k])];
        for (std::size_t k = 0; k < 3; ++k) {
          const std::size_t next = (k + 1) % 3;
          count += edge_crosses_face(y[k], y[next], x[0], x[1], x[2]) + edge_crosses_face(x[k], x[next], y[0], y[1], y[2]);
        }
      }
    return count;
  }
  // After all steps.
  int most_crossings(int steps) {
    int most = 0;
    for (int i = 0; i < steps; ++i) run.step(), most = std::max(most, crossings());
    return most;
  }
  double distance_to(const Vec3& x) {
    double least = HUGE_VAL;
    for (const auto& [a, b, c] : faces()) least = std::min(least, closest_on_triangle(x, a, b, c).distance);
    return least;
  }

 private:
  OnMesh(const TextFile& mesh, const std::string& motion, const std::string& rest)
      : run(scene_from("bodies:\n  - {shape: {mesh: {file: " + mesh.path().substr(mesh.path().rfind('/') + 1) + "}}" + motion +
                       "}\n" + rest + solver)) {}

  const MeshSurface& mesh() { return shape_library().meshes[run.world().properties[run.slot(0)].shape.data]; }
  std::vector<TriangleNodes> faces() {
    std::vector<TriangleNodes> all;
    for (const SurfaceFace& f : run.simulation->search.surfaces.faces) {
      const auto place = [&](std::size_t k) { return run.world().position[static_cast<std::size_t>(f.nodes[k])]; };
      all.push_back({place(0), place(1), place(2)});
    }
    return all;
  }
};

}  // namespace

// The nodes are 0.25 m apart, the needle is 0.1 m wide. Slow, and at 0.5 m a step.
TEST(SurfaceOnMesh, AClothLiesOnATipBetweenItsNodes) {
  for (const auto& [width, speed, two_sides] :
       {std::tuple(0.05, 0, false), {0.05, 30, false}, {0.5, 0, false}, {0.5, 30, false}, {0.05, 0, true}, {0.5, 30, true}}) {
    SCOPED_TRACE(std::to_string(width) + " m, " + std::to_string(speed) + " m/s" + (two_sides ? ", two sides" : ""));
    OnMesh on(pyramid(width, two_sides), "",
              "  - {shape: {plane: {normal: [0, 0, 1]}}}\ncloths:\n  - grid: {size: [2, 2], nodes: [9, 9]}\n    mass: 1\n"
              "    thickness: 0.02\n    position: [0.09, 0.06, 0.75]\n    velocity: [0, 0, " +
                  std::to_string(-speed) + "]\n    links: {stiffness: 5000, damping: 0.01}\n");
    EXPECT_EQ(on.most_crossings(120), 0);
    EXPECT_NEAR(on.distance_to(tip), radius, 2e-4);
  }
}

// Only the middle segment, of 0.25 m, is over the ridge, and the ridge's ends are a meter off: edges alone hold it, its ends
// hang from it.
TEST(SurfaceOnMesh, AThreadHangsOverARidge) {
  OnMesh on(roof(2), "",
            "threads:\n  - {points: [[-0.625, 0.1, 0.65], [0.625, 0.1, 0.65]], segments: 5, radius: 0.01, mass: 0.1}\n");
  EXPECT_EQ(on.most_crossings(60), 0);
  EXPECT_NEAR(on.distance_to({0, 0.1, height}), radius, 2e-4);
  EXPECT_LT(on.run.position(1).z(), height - 0.3);
  EXPECT_LT(on.run.position(6).z(), height - 0.3);
}

// Let down, it lies there; thrown, it comes off again.
TEST(SurfaceOnMesh, ASoftBlockIsNotImpaled) {
  for (const double speed : {0, 5}) {
    OnMesh on(pyramid(0.05), "",
              "solids:\n  - block: {size: [0.6, 0.6, 0.3], cells: [2, 2, 1]}\n    position: [0.02, 0.01, 0.8]\n"
              "    velocity: [0, 0, " +
                  std::to_string(-speed) +
                  "]\n    density: 200\n    youngs_modulus: 1.0e+5\n    poissons_ratio: 0.3\n    damping: 0.01\n"
                  "    thickness: 0.02\n");
    double least = HUGE_VAL;
    for (int i = 0; i < 30; ++i) {
      EXPECT_EQ(on.most_crossings(1), 0) << i;
      least = std::min(least, on.distance_to(tip));
    }
    EXPECT_GT(least, 0.5 * radius);
    EXPECT_LT(least, 1.01 * radius);
    if (speed == 0) {
      EXPECT_NEAR(on.distance_to(tip), radius, 2e-4);
    }
  }
}

// A needle that turns about its foot, its tip at 12 m/s: 0.19 m a step.
TEST(SurfaceOnMesh, ATipThatSwingsTakesAClothAlong) {
  OnMesh on(pyramid(0.05), ", motion: kinematic, angular_velocity: [0, 20, 0]",
            "gravity: [0, 0, 0]\ncloths:\n  - grid: {size: [1, 1], nodes: [5, 5]}\n    mass: 1\n    thickness: 0.02\n"
            "    orientation: {axis: [0, 1, 0], angle: 90}\n    position: [0.4, 0.06, 0.5]\n"
            "    links: {stiffness: 5000, damping: 0.01}\n");
  EXPECT_EQ(on.most_crossings(5), 0);
  Vec3 velocity = Vec3::Zero();
  for (Id k = 1; k <= 25; ++k) velocity += on.run.velocity(k) / 25;
  EXPECT_GT(velocity.x(), 1);
}

}  // namespace unibody::small_worlds::surface_on_mesh_test
