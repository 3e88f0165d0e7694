// Bodies of other shapes than spheres and boxes: how they stand, roll and bounce, by elementary mechanics.
#include <gtest/gtest.h>

#include <cmath>

#include "collide/mesh_side.hpp"
#include "scene/scene_text.hpp"
#include "small_worlds.hpp"
#include "world/shape_library.hpp"

namespace unibody::small_worlds::shapes_test {

namespace {

constexpr double g = 9.81;

const std::string floor_of_planes = "bodies:\n  - {shape: {plane: {normal: [0, 0, 1]}}}\n";
const std::string floor_of_boxes = "bodies:\n  - {shape: {box: {size: [20, 20, 1]}}, position: [0, 0, -0.5], motion: fixed}\n";
const std::string floor_of_triangles =
    "bodies:\n  - {shape: {mesh: {height_field: {size: [20, 20], cells: [13, 17], hills: 0}}}, motion: fixed}\n";
const std::string grounds[] = {floor_of_planes, floor_of_boxes, floor_of_triangles};

std::string entry(const std::string& shape, const std::string& more) {
  return "  - {shape: {" + shape + "}, density: 1000, " + more + "}\n";
}
const std::string cylinder = "cylinder: {radius: 0.1, length: 0.3}", capsule = "capsule: {radius: 0.1, length: 0.3}";
const std::string wedge = "hull: {points: [[0, 0, 0], [0.4, 0, 0], [0, 0.3, 0], [0, 0, 0.3], [0.4, 0, 0.3], [0, 0.3, 0.3]]}";

}  // namespace

TEST(Shapes, StandAndLieStill) {
  for (const std::string& ground : grounds) {
    const std::string lying = "orientation: {axis: [1, 0, 0], angle: 90}";
    Experiment run(scene_from_text(ground + entry(cylinder, "position: [0.03, 0.04, 0.1501]") +
                                   entry(cylinder, "position: [1, 0, 0.1001], " + lying) +
                                   entry(capsule, "position: [2, 0, 0.1001], " + lying) +
                                   entry(wedge, "position: [3, 0, 0.1501]") + "solver: {tolerance: 0}\n"));
    run.seconds(2);
    const Vec3 at[] = {run.position(1), run.position(2), run.position(3), run.position(4)};
    run.seconds(4);
    for (Id k = 1; k <= 4; ++k) {
      EXPECT_LT((run.position(k) - at[k - 1]).norm(), 1e-6) << ground << k;
      EXPECT_LT(run.velocity(k).norm(), 1e-6) << ground << k;
    }
    EXPECT_NEAR(run.position(1).z(), 0.15, 5e-4);
    EXPECT_NEAR(run.position(2).z(), 0.1, 5e-4);
    EXPECT_NEAR(run.position(4).z(), 0.15, 5e-4);
  }
}

// a = 2/3 g sin(angle) for a solid cylinder, 5/7 for a sphere, on each kind of ground, without leaving its line.
TEST(Shapes, RollDownASlope) {
  const double angle = std::atan(0.2), pull = g * std::sin(angle);
  for (const std::string& ground : grounds) {
    const std::string lying = "orientation: {axis: [1, 0, 0], angle: 90}";
    Scene scene = scene_from_text(ground + entry(cylinder, "position: [-4, 0.01, 0.1], " + lying) +
                                  entry("sphere: {radius: 0.1}", "position: [-4, 2, 0.1]"));
    scene.gravity = g * Vec3(std::sin(angle), 0, -std::cos(angle));
    scene.time.substeps = 4;
    Experiment run(scene);
    run.seconds(0.2);
    const double v_cylinder = run.velocity(1).x(), v_sphere = run.velocity(2).x();
    run.seconds(1.5);
    const double t = std::floor(1.5 / run.h() + 0.5) * run.h();
    EXPECT_NEAR((run.velocity(1).x() - v_cylinder) / t, 2.0 / 3 * pull, 0.005 * pull) << ground;
    EXPECT_NEAR((run.velocity(2).x() - v_sphere) / t, 5.0 / 7 * pull, 0.005 * pull) << ground;
    EXPECT_NEAR(run.position(1).y(), 0.01, 1e-4) << ground;
    EXPECT_NEAR(run.state(1).angular_velocity.z(), 0, 1e-3) << ground;
    EXPECT_NEAR(run.position(1).z(), 0.1, 1e-3) << ground;
  }
}

// Parts that make up a block move as the block does.
TEST(Shapes, CompoundOfBoxesFallsAsTheBox) {
  const std::string parts =
      "compound: {parts: [{shape: {box: {size: [0.2, 0.2, 0.1]}}, position: [-0.1, 0, 0]},"
      " {shape: {box: {size: [0.2, 0.2, 0.1]}}, position: [0.1, 0, 0]}]}";
  const std::string turned = "position: [0, 0, 0.4], orientation: {axis: [0, 1, 0], angle: 20}";
  Experiment whole(scene_from_text(floor_of_planes + entry("box: {size: [0.4, 0.2, 0.1]}", turned)));
  Experiment made(scene_from_text(floor_of_planes + entry(parts, turned)));
  EXPECT_NEAR(made.world().properties[0].mass, whole.world().properties[0].mass, 1e-12);
  EXPECT_LT((made.world().properties[0].inertia - whole.world().properties[0].inertia).norm(), 1e-12);
  whole.seconds(0.2), made.seconds(0.2);  // still in the air
  EXPECT_LT((made.position(1) - whole.position(1)).norm(), 1e-12);
  whole.seconds(3), made.seconds(3);
  EXPECT_NEAR(made.position(1).z(), 0.05, 5e-4);
  EXPECT_NEAR(whole.position(1).z(), 0.05, 5e-4);
  EXPECT_LT(made.velocity(1).norm(), 1e-3);
}

// 200 bodies of all shapes thrown on hills in a heap, at 0.5 m a step: the upper press the lower through the triangles, and all
// come out again.
namespace {

// m, of a height field over a place; -infinity beside it.
double height_at(const MeshSurface& field, double x, double y) {
  for (const MeshSurface::Triangle& t : field.triangles) {
    const auto node = [&](std::size_t k) { return field.nodes[static_cast<std::size_t>(t.nodes[k])]; };
    const Vec3 a = node(0), b = node(1) - a, c = node(2) - a;
    const double area = b.x() * c.y() - b.y() * c.x(), u = x - a.x(), v = y - a.y();
    const double of_b = (u * c.y() - v * c.x()) / area, of_c = (b.x() * v - b.y() * u) / area;
    if (of_b >= 0 && of_c >= 0 && of_b + of_c <= 1) return a.z() + of_b * b.z() + of_c * c.z();
  }
  return -HUGE_VAL;
}

}  // namespace

TEST(Shapes, NoneOfAHeapThrownOnHillsIsLost) {
  const std::string walls =
      "  - {shape: {plane: {normal: [1, 0, 0]}}, position: [-1.4, 0, 0]}\n"
      "  - {shape: {plane: {normal: [-1, 0, 0]}}, position: [1.4, 0, 0]}\n"
      "  - {shape: {plane: {normal: [0, 1, 0]}}, position: [0, -1.4, 0]}\n"
      "  - {shape: {plane: {normal: [0, -1, 0]}}, position: [0, 1.4, 0]}\n";
  const std::string heap = R"(
  - pile:
      count: 100
      columns: [6, 6]
      gap: 0.01
      seed: 5
      mix:
        - {shape: {sphere: {radius: 0.09}}, scale: [0.6, 1.2]}
        - {shape: {box: {size: [0.16, 0.14, 0.1]}}, scale: [0.6, 1.2]}
        - {shape: {capsule: {radius: 0.05, length: 0.14}}, scale: [0.6, 1.2]}
        - {shape: {cylinder: {radius: 0.08, length: 0.1}}, scale: [0.6, 1.2]}
        - {shape: {hull: {points: [[0.1, 0, 0], [-0.1, 0, 0], [0, 0.08, 0], [0, -0.08, 0], [0, 0, 0.09], [0, 0, -0.05]]}}, scale: [0.6, 1.2]}
        - {shape: {compound: {parts: [{shape: {box: {size: [0.2, 0.05, 0.05]}}}, {shape: {box: {size: [0.05, 0.2, 0.05]}}}]}}}
    density: 2600
    velocity: [0, 0, -30]
    position: [0, 0, 1.5]
)";
  Experiment run(
      scene_from_text("bodies:\n  - {shape: {mesh: {height_field: {size: [3, 3], cells: [12, 12], hills: 2, seed: 3}}}}\n" +
                      walls + heap + "solver: {name: gauss_seidel, iterations: 10}\n"));
  const MeshSurface& hills = shape_library().meshes[run.world().properties[run.slot(0)].shape.data];
  run.steps(60);
  for (Id k = 5; k < 105; ++k) {
    const Vec3 x = run.position(k);
    EXPECT_LT(x.head<2>().cwiseAbs().maxCoeff(), 1.4) << k;
    EXPECT_GT(x.z(), height_at(hills, x.x(), x.y()) - 0.05) << k << " at " << x.transpose();  // of 0.1 m and more
  }
}

// On a net whose nodes are further apart than they are wide: they come to rest on it, and fast ones do not get through.
TEST(Shapes, ClothHoldsThemSlowAndFast) {
  const std::string cross =
      "compound: {parts: [{shape: {box: {size: [0.2, 0.05, 0.05]}}}, {shape: {box: {size: [0.05, 0.2, 0.05]}}}]}";
  for (const std::string& shape : {cylinder, capsule, wedge, cross})
    for (const double speed : {0.0, 60.0}) {
      Scene scene =
          scene_from_text("bodies:\n  - {shape: {" + shape + "}, mass: 0.1, position: [0.02, 0.03, 0.4], velocity: [0, 0, " +
                          std::to_string(-speed) +
                          "], angular_velocity: [3, 2, 0]}\ncloths:\n  - grid: {size: [1, 1], nodes: [11, 11]}\n    mass: 0.5\n  "
                          "  thickness: 0.02\n"
                          "    links: {}\n    pins: [{node: [0, 0]}, {node: [10, 0]}, {node: [0, 10]}, {node: [10, 10]}]\n"
                          "solver: {name: gauss_seidel, iterations: 50}\n");
      Experiment run(scene);
      double above = 1;  // m, of the body over the lowest node
      for (int i = 0; i < (speed > 0 ? 25 : 150); ++i) {
        run.step();
        double lowest = 1;
        for (Id k = 1; k <= 121; ++k) lowest = std::min(lowest, run.position(k).z());
        above = std::min(above, run.position(0).z() - lowest);
      }
      EXPECT_GT(above, 0) << shape << speed;
      if (speed == 0) {
        EXPECT_LT(run.velocity(0).norm(), 0.2) << shape;
      }
    }
}

// Grains that do not turn, on each shape where it is flat or round: at rest at the sum of the radii.
TEST(Shapes, ParticlesRestOnThem) {
  const std::string lying = "orientation: {axis: [1, 0, 0], angle: 90}, motion: fixed";
  const auto fixed = [](const std::string& shape, const std::string& more) {
    return "  - {shape: {" + shape + "}, " + more + "}\n";
  };
  Experiment run(scene_from_text(
      "bodies:\n" + fixed(cylinder, "motion: fixed, position: [0, 0, 0]") + fixed(cylinder, lying + ", position: [1, 0, 0]") +
      fixed(capsule, lying + ", position: [2, 0, 0]") + fixed(wedge, "motion: fixed, position: [3, 0, 0]") +
      "  - {shape: {particle: {radius: 0.02}}, mass: 0.01, position: [0.03, 0.02, 0.3]}\n"
      "  - {shape: {particle: {radius: 0.02}}, mass: 0.01, position: [1, 0.02, 0.3]}\n"
      "  - {shape: {particle: {radius: 0.02}}, mass: 0.01, position: [2, 0.02, 0.3]}\n"
      "  - {shape: {particle: {radius: 0.02}}, mass: 0.01, position: [3, 0.01, 0.3]}\n"));
  run.seconds(2);
  const double at[] = {0.15 + 0.02, 0.1 + 0.02, 0.1 + 0.02, 0.15 + 0.02};
  for (Id k = 4; k < 8; ++k) {
    EXPECT_NEAR(run.position(k).z(), at[k - 4], 5e-4) << k;
    EXPECT_LT(run.velocity(k).norm(), 1e-4) << k;
  }
}

namespace {

// A table of 0.8 x 0.6 x 0.45 m in Wavefront OBJ: a top and four legs, each a closed surface.
std::string table() {
  std::string nodes, faces;
  int first = 1;
  const auto box = [&](const Vec3& low, const Vec3& high) {
    for (int k = 0; k < 8; ++k)
      nodes += "v " + std::to_string((k & 1 ? high : low).x()) + " " + std::to_string((k & 2 ? high : low).y()) + " " +
               std::to_string((k & 4 ? high : low).z()) + "\n";
    for (const auto& face : {std::array{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}}) {
      faces += "f";
      for (const int corner : face) faces += " " + std::to_string(first + corner);
      faces += "\n";
    }
    first += 8;
  };
  box({0, 0, 0.4}, {0.8, 0.6, 0.45});
  for (const double x : {0.0, 0.74})
    for (const double y : {0.0, 0.54}) box({x, y, 0}, {x + 0.06, y + 0.06, 0.4});
  return nodes + faces;
}

}  // namespace

// A solid of convex pieces drops on one foot, rocks and stands on four, and comes to rest: what it slipped when it landed, at
// most a hundredth of its bounding radius of 0.54 m, is taken back by its memory of creep, by a tenth in each step of 16 ms.
// With accelerated Jacobi and few iterations that is slower.
TEST(Shapes, ATableOfConvexPiecesComesToRestOnItsFeet) {
  const TextFile file(table());
  const double top = 0.8 * 0.6 * 0.05, legs = 4 * 0.06 * 0.06 * 0.4, height = (0.425 * top + 0.2 * legs) / (top + legs);
  for (const std::string solver : {"gauss_seidel", "accelerated_jacobi"})
    for (const int iterations : {10, 50}) {
      Experiment run(scene_from_text(floor_of_planes + "  - {shape: {compound: {mesh: " + file.path() +
                                     ", pieces: 6}}, density: 600, position: [0, 0, 0.34], orientation: {axis: [0.6, 0.8, 0], "
                                     "angle: 8}}\nsolver: {name: " +
                                     solver + ", iterations: " + std::to_string(iterations) + "}\n"));
      EXPECT_NEAR(run.world().properties[run.slot(1)].mass, 600 * (top + legs), 1e-9);
      run.steps(100);
      double bound = 1e-4;  // m/s
      for (int k = 0; k < 3; ++k) {
        constexpr int landed = 10;  // steps
        if (solver == "gauss_seidel") bound = std::max(0.1 * 0.01 * 0.54 / 0.016 * std::pow(0.9, 100 * (k + 1) - landed), 1e-11);
        EXPECT_LT(run.velocity(1).norm(), bound) << solver << ' ' << iterations << ' ' << k;
        EXPECT_LT(run.penetration(), 0.1 * bound) << solver << ' ' << iterations << ' ' << k;  // m
        const Vec3 at = run.position(1);
        run.steps(100);
        EXPECT_LT((run.position(1) - at).norm(), 0.2 * bound) << solver << ' ' << iterations << ' ' << k;
        bound = std::max(1e-2 * bound, 1e-11);
      }
      EXPECT_NEAR(run.position(1).z(), height, 1e-6) << solver << ' ' << iterations;
      const Mat3 axes = run.state(1).orientation.toRotationMatrix();  // principal: some one is upright
      EXPECT_NEAR(axes.row(2).cwiseAbs().maxCoeff(), 1, 1e-12) << solver << ' ' << iterations;
    }
}

TEST(Restitution, BallBouncesToTheHeightsOfItsRestitution) {
  for (const std::string name : {"gauss_seidel", "accelerated_jacobi"})
    for (const double e : {0.5, 0.8}) {
      Scene scene = scene_from_text(
          "bodies:\n  - {shape: {sphere: {radius: 0.1}}, mass: 1, position: [0, 0, 1.1]}\n"
          "  - {shape: {plane: {normal: [0, 0, 1]}}}\nmaterials: {m: {friction: 0.5, restitution: " +
          std::to_string(e) + "}}\nsolver: {name: " + name + "}\n");
      scene.time.substeps = 32;
      Experiment run(scene);
      int bounces = 0;
      double top = 0, before = 0, rest = 0;  // rest: s, from when on it lies
      std::vector<double> tops;
      for (int k = 1; k * run.h() < 8; ++k) {
        run.step();
        const double v = run.velocity(0).z();
        if (std::abs(v) > 1e-6) rest = k * run.h();
        top = std::max(top, run.position(0).z() - 0.1);
        if (v > 0 && before < 0) {
          if (bounces > 0 && bounces < 3) tops.push_back(top);
          top = 0, ++bounces;
        }
        before = v;
      }
      for (std::size_t n = 0; n < tops.size(); ++n)  // e^(2n) H, H = 1 m
        EXPECT_NEAR(tops[n] / std::pow(e, 2.0 * static_cast<double>(n + 1)), 1, 0.01) << name << ' ' << e;
      EXPECT_NEAR(rest / (std::sqrt(2 / g) * (1 + e) / (1 - e)), 1, 0.01) << name << ' ' << e;
      EXPECT_LT(run.velocity(0).norm(), 1e-6);
      EXPECT_NEAR(run.position(0).z(), 0.1, 1e-3);
    }
}

// A sphere hits the ground at an angle: it slides through the impact, or leaves rolling.
TEST(Restitution, ObliqueImpactTurnsASphere) {
  const double r = 0.1, v_n = 2, v_t = 3;
  int sliding = 0, rolling = 0;
  for (const std::string solver : {"gauss_seidel", "jacobi", "accelerated_jacobi"})
    for (const double e : {0.0, 0.3, 0.6, 1.0})
      for (const double mu : {0.05, 0.1, 0.2, 0.5, 0.9}) {
        const std::string what = solver + ", e " + std::to_string(e) + ", mu " + std::to_string(mu);
        Scene scene = scene_from_text(
            "bodies:\n  - {shape: {sphere: {radius: 0.1}}, mass: 1, position: [0, 0, 0.1]}\n"
            "  - {shape: {plane: {normal: [0, 0, 1]}}}\ngravity: [0, 0, 0]\nmaterials: {m: {friction: " +
            std::to_string(mu) + ", restitution: " + std::to_string(e) + "}}\nsolver: {name: " + solver +
            ", iterations: 1000, tolerance: 0}\n");
        Experiment run(scene);
        run.world().velocity[run.slot(0)] = Vec3(v_t, 0, -v_n);
        run.step();
        const bool slides = v_t >= 3.5 * mu * (1 + e) * v_n;
        ++(slides ? sliding : rolling);
        EXPECT_NEAR(run.velocity(0).z(), e * v_n, 1e-6) << what;
        EXPECT_NEAR(run.velocity(0).x(), slides ? v_t - mu * (1 + e) * v_n : 5.0 / 7 * v_t, 1e-6) << what;
        const double spin = slides ? 2.5 / r * mu * (1 + e) * v_n : 5.0 / 7 * v_t / r;
        EXPECT_NEAR(run.state(0).angular_velocity.y(), spin, 1e-6 * spin) << what;
      }
  EXPECT_GT(std::min(sliding, rolling), 12);
}

TEST(Restitution, PileGainsNoEnergyAndComesToRest) {
  Scene scene = scene_from_text(
      "bodies:\n  - container: {size: [1, 1]}\n  - pile: {count: 60, columns: [4, 4], seed: 3, mix: [{shape: {sphere: {radius: "
      "0.08}}}, {shape: {box: {size: [0.14, 0.12, 0.1]}}}, {shape: {cylinder: {radius: 0.06, length: 0.12}}}]}\n    density: "
      "1000\n    position: [0, 0, 0.05]\nmaterials: {m: {friction: 0.4, restitution: 0.5}}\n");
  Experiment run(scene);
  const double start = run.energy();
  double before = start, gained = 0;
  for (int i = 0; i < 500; ++i) {
    run.step();
    const double now = run.energy();
    gained += std::max(0.0, now - before), before = now;
  }
  EXPECT_LT(gained, 1e-4 * start) << "of all steps together";
  EXPECT_LT(run.kinetic_energy(), 1e-4 * start);
}

}  // namespace unibody::small_worlds::shapes_test
