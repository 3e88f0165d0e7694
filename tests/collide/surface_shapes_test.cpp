// Contacts of every kind of solid with the faces of sheets and of closed surfaces, against samples of the solid: the least gap,
// and of every contact its normal, its two points and the arm.
#include <gtest/gtest.h>

#include "collide/sampled_solids.hpp"
#include "collide/surface_contacts.hpp"
#include "collide/surface_world.hpp"

namespace unibody::samples::surface_shapes_test {

namespace {

constexpr double radius = 0.005;  // m, of nodes

const std::vector<Shape> solids() {
  std::vector<Shape> all;
  for (const ShapeKind kind : {ShapeKind::sphere, ShapeKind::box, ShapeKind::capsule, ShapeKind::cylinder, ShapeKind::hull,
                               ShapeKind::compound, ShapeKind::mesh})
    for (const Shape& s : examples_of(kind)) all.push_back(s);
  return all;
}

// Hills are touched from above: they look down at what is level in these axes, but for half a radian.
Quat looking_down(const Mat3& axes, Random& random) {
  const Quat tilt(Eigen::AngleAxisd(random(-0.5, 0.5), Vec3(random(-1, 1), random(-1, 1), 0).normalized()));
  return Quat(axes) * Quat(0, 1, 0, 0) * tilt;
}

// A surface with one solid, body `id`.
struct Scene {
  SurfaceWorld s;
  Id id = 0;
  Vec3 origin = Vec3::Zero();
  Mat3 turn = Mat3::Identity();

  void add(const Shape& shape, const Vec3& place, const Quat& orientation) {
    Body solid = body(0, shape.kind, shape.size, place);
    solid.properties.shape = shape, solid.state.orientation = orientation;
    if (shape.kind == ShapeKind::mesh) solid.properties.motion = Motion::fixed;
    id = s.add(solid);
  }
};

// m, with the samples' error. A mesh has no size: only nodes, of theirs, may lie on its faces.
double error(const Shape& shape, double distance) {
  const Shape touching = shape.kind == ShapeKind::mesh ? Shape{ShapeKind::sphere, {radius, 0, 0}} : shape;
  return face_loss(touching, distance) + 2 * Cloud::shortfall + fineness;
}

double least_distance(const Contacts& found) {
  double least = HUGE_VAL;
  for (const SurfaceContact& c : found.surface) least = std::min(least, c.gap);
  for (const ContactPoint& c : found.points) least = std::min(least, c.gap);
  return least + radius;
}

// Both sides are held where the face is: friction then turns the two together by nothing. Off the face by the gap is the solid.
void expect_contacts_join_the_surfaces(const Scene& scene, const Contacts& found, const Placed& solid) {
  for (const SurfaceContact& c : found.surface) {
    EXPECT_EQ(c.ids[0], scene.id);
    EXPECT_NEAR(c.normal.norm(), 1, 1e-12);
    const Vec3 on_face = scene.s.point(c, -1), on_solid = on_face + (c.gap + radius) * c.normal;
    EXPECT_LT((scene.s.point(c, 1) + c.arm - on_face).norm(), 1e-13);
    const double distance = c.gap + radius;
    const double tolerance = error(solid.body.properties.shape, distance) + within_side(solid, c.normal) +
                             (is_nearest_points(c.feature) ? beside(solid.body.properties.shape, distance) : 0);
    EXPECT_TRUE(is_on_surface(solid, on_solid, -c.normal, tolerance)) << c.gap << " feature " << c.feature;
  }
}

// A sheet of shifted nodes in one plane, or a block; the solid's lowest point `height` over the middle.
struct OverAPlane {
  Scene scene;
  Vec3 up;
  double lowest;  // m, of the solid over the face, as sampled
  Placed solid;

  static Placed placed(Scene& scene, const Shape& shape, bool closed, double height, Random& random) {
    scene.origin = random.vector(-1, 1), scene.turn = random.turn().toRotationMatrix();
    if (closed) {
      scene.s.add_closed_box({.9, .8, .4}, radius, scene.origin - 0.4 * scene.turn.col(2), scene.turn);
    } else {
      Sheet flat = sheet(8, 7, 1.8, 1.6);
      for (Vec3& x : flat.nodes) x = scene.origin + scene.turn * (x + Vec3(random(-.05, .05), random(-.05, .05), 0));
      scene.s.add_surface(flat.nodes, flat.cells, radius);
    }
    const Vec3 up = scene.turn.col(2);
    const Quat orientation = is_hills(shape) ? looking_down(scene.turn, random) : random.turn();
    const double room = is_hills(shape) ? 0.1 : 0.2;
    const Vec3 beside = scene.turn * Vec3(random(-room, room), random(-room, room), 0);
    Placed at_origin(shape, Vec3::Zero(), orientation, false);
    double reach = 0;
    for (const Cloud& x : at_origin.clouds) reach = std::max(reach, (-up.transpose() * x.points).maxCoeff());
    const Vec3 place = scene.origin + beside + (reach + height) * up;
    scene.add(shape, place, orientation);
    return Placed(shape, place, orientation, false);
  }
  OverAPlane(const Shape& shape, bool closed, double height, Random& random)
      : lowest(height), solid(placed(scene, shape, closed, height, random)) {
    up = scene.turn.col(2);
  }
};

}  // namespace

// Over the face or pressed into it, deeper than the sheet is thick: the least gap is the lowest sample's height.
TEST(SurfaceShapes, OverASheetAndABlockTheLowestPointIsTheLeastGap) {
  Random random(1);
  int contacts = 0;
  for (const Shape& shape : solids())
    for (const bool closed : {false, true})
      for (int k = 0; k < 20; ++k) {
        SCOPED_TRACE(std::string(shape_names[std::size_t(shape.kind)]) + (closed ? " on a block, " : " on a sheet, ") +
                     std::to_string(k));
        const double height = random(-0.02, 0.04);
        OverAPlane o(shape, closed, height, random);
        o.scene.s.settings.margin = 0.05;
        const Contacts found = o.scene.s.contacts();
        const double least = least_distance(found);
        EXPECT_LE(least, height + error(shape, height));
        EXPECT_GE(least, height - Cloud::shortfall - 1e-12);
        // no neighbour's edge rises more; between two edges at right angles that is the square root of 2 of it
        for (const SurfaceContact& c : found.surface) EXPECT_LT((c.normal - o.up).norm(), 1.5 * lean_of_boxes) << c.feature;
        expect_contacts_join_the_surfaces(o.scene, found, o.solid);
        contacts += static_cast<int>(found.surface.size());
      }
  EXPECT_GT(contacts, 500);
}

// Beside triangles of any orientation: the least gap is the distance of the two pieces that are nearest, and each normal
// separates two pieces by as much as its gap.
TEST(SurfaceShapes, BesideTrianglesTheLeastGapIsTheDistance) {
  Random random(2);
  int compared = 0;
  for (const Shape& shape : solids())
    for (int k = 0; k < (shape.kind == ShapeKind::mesh ? 5 : 12); ++k) {
      SCOPED_TRACE(std::string(shape_names[std::size_t(shape.kind)]) + ", " + std::to_string(k));
      const Quat orientation = random.turn();
      const Placed solid(shape, Vec3::Zero(), orientation, false);
      Vec3 aside = random.vector(-1, 1).normalized();
      if (is_hills(shape)) aside = orientation * Vec3(aside.x() / 2, aside.y() / 2, 1);
      const Sheet triangles = soup(random, 4, aside * random(0.3, 0.6), 0.1, 0.3);
      std::vector<Cloud> faces;
      for (const auto& c : triangles.cells) {
        const auto node = [&](std::size_t i) { return triangles.nodes[static_cast<std::size_t>(c[i])]; };
        faces.emplace_back(Patches{triangle(node(0), node(1), node(2))});
      }
      bool apart = true;
      for (const Cloud& x : solid.clouds)
        for (const Cloud& y : faces) apart = apart && any_separates(x, y, 0.02, fineness);
      if (!apart) continue;
      Scene scene;
      scene.s.add_surface(triangles.nodes, triangles.cells, radius);
      scene.add(shape, Vec3::Zero(), orientation);
      scene.s.settings.margin = 1;
      const Contacts found = scene.s.contacts();
      const double least = least_distance(found), tolerance = error(shape, least);
      bool is_attained = false;
      for (const Cloud& x : solid.clouds)
        for (const Cloud& y : faces) {
          EXPECT_TRUE(any_separates(x, y, least - fineness, fineness)) << least;
          is_attained = is_attained || !any_separates(x, y, least + tolerance - fineness, fineness);
        }
      EXPECT_TRUE(is_attained) << least;
      for (const SurfaceContact& c : found.surface) {
        if (c.gap + radius > least + tolerance) continue;  // one that is only over a part of the face
        double most = -HUGE_VAL;
        for (const Cloud& x : solid.clouds)
          for (const Cloud& y : faces) most = std::max(most, sampled_separation(x, y, c.normal));
        EXPECT_GE(most, least - tolerance);
      }
      expect_contacts_join_the_surfaces(scene, found, solid);
      ++compared;
    }
  EXPECT_GT(compared, 30);
}

}  // namespace unibody::samples::surface_shapes_test
