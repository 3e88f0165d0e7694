// The surface of a solid has an inside: what is there is pushed out, whichever way it came, and nothing holds it there.
#include <gtest/gtest.h>

#include "collide/surface_world.hpp"
#include "shortest_turn.hpp"

namespace unibody::closed_surface_test {
namespace {

using namespace samples;

constexpr double r = 0.01;  // m, of the nodes
const Vec3 half(0.5, 0.4, 0.3);

// A grain whose centre is inside, by less than its own size: one that stands still and one on its way in or out alike.
TEST(ClosedSurface, AGrainInsideIsPushedOutThroughTheFacesThatAreNear) {
  Random random(3);
  int inside = 0;
  for (int k = 0; k < 1000; ++k) {
    SurfaceWorld s;
    const Mat3 turn = random.turn().toRotationMatrix();
    const Vec3 origin = random.vector(-1, 1), at = random.vector(-1, 1).cwiseProduct(half);
    s.add_closed_box(half, r, origin, turn);
    const double radius = random(0.05, 0.1);
    const Id grain = s.add(sphere(0, radius, origin + turn * at));
    s[grain].state.velocity = random.vector(-3, 3), s.settings.has_past = true;
    const Vec3 depth = half - at.cwiseAbs();
    for (const SurfaceContact& c : s.contacts().surface) {
      const Vec3 normal = turn.transpose() * c.normal;
      Eigen::Index axis = 0;
      ASSERT_GT(normal.cwiseAbs().maxCoeff(&axis), 1 - 1e-12) << k;
      EXPECT_GT(normal[axis] * at[axis], 0) << k;
      EXPECT_NEAR(c.gap, -depth[axis] - radius - r, 1e-12) << k;
      EXPECT_LE(depth[axis], radius + r) << k;
      EXPECT_EQ(c.beyond, 0) << k;  // no hurry to where it was before
      ++inside;
    }
  }
  EXPECT_GT(inside, 100);
}

// The same of a node of a cloth, and of one that has just gone out: it is not told to go back in.
TEST(ClosedSurface, ANodeThatHasLeftIsNotCalledBack) {
  for (const double speed : {0.0, 2.0, -2.0})
    for (const double height : {-0.006, 0.006}) {
      SurfaceWorld s;
      s.add_closed_box(half, r, Vec3::Zero(), Mat3::Identity());
      const Id node = s.add_surface({{0.13, 0.07, 0.3 + height}, {0.1, 0.1, 3}, {0.2, 0.1, 3}}, {{0, 1, 2}}, r);
      s[node].state.velocity = Vec3(0, 0, speed);
      s.settings.has_past = true, s.settings.step = 0.008;
      int touching = 0;
      for (const SurfaceContact& c : s.contacts().surface) {
        if (c.ids[0] != node) continue;
        ++touching;
        EXPECT_GT(c.normal.z(), 0.999) << speed << ' ' << height;
        EXPECT_NEAR(c.gap, height - 2 * r, 1e-12) << speed << ' ' << height;
        EXPECT_EQ(c.beyond, 0);
      }
      EXPECT_EQ(touching, 1) << speed << ' ' << height;
    }
}

// Two crossed edges, one of each box, that have passed into each other: parted along the way out of both.
TEST(ClosedSurface, EdgesInsideOfEachOtherArePushedApart) {
  for (const double overlap : {-0.004, 0.004, 0.012}) {
    SurfaceWorld s;
    const Mat3 on_edge = Eigen::AngleAxisd(EIGEN_PI / 4, Vec3::UnitX()).toRotationMatrix();
    const Mat3 across = Eigen::AngleAxisd(EIGEN_PI / 2, Vec3::UnitZ()).toRotationMatrix() * on_edge;
    const Vec3 cube = Vec3::Constant(0.3);
    const double height = 0.3 * std::sqrt(2.0);
    s.add_closed_box(cube, r, Vec3(0.05, 0.04, -height), on_edge);
    const Id upper = s.add_closed_box(cube, r, Vec3(-0.03, 0.02, height - overlap), across);
    int edges = 0;
    for (const SurfaceContact& c : s.contacts().surface) {
      if (c.feature != 1000) continue;
      ++edges;
      EXPECT_GT((c.ids[0] >= upper ? 1 : -1) * c.normal.z(), 0.999) << overlap;
      EXPECT_NEAR(c.gap, -overlap - 2 * r, 1e-12) << overlap;
    }
    EXPECT_EQ(edges, 1) << overlap;
  }
}

// A box on its corner, so much deeper than the top of a closed box.
Contacts corner_in(SurfaceWorld& s, const Vec3& plate, const Vec3& at, double depth) {
  s.add_closed_box(plate, r, Vec3::Zero(), Mat3::Identity());
  const Quat turn = shortest_turn(-Vec3::Ones(), -Vec3::UnitZ());
  s.add(box(0, Vec3::Constant(0.2), at + Vec3(0, 0, plate.z() + 0.2 * std::sqrt(3.0) - depth), turn));
  return s.contacts();
}

// What lies behind a corner that has gone through a thin part is not a wall that would hold it.
TEST(ClosedSurface, TheFarSideOfAThinPartIsNoWall) {
  SurfaceWorld s;
  const Contacts found = corner_in(s, Vec3(0.5, 0.4, 0.02), Vec3(0.2, 0.08, 0), 0.05);
  int corners = 0;
  for (const SurfaceContact& c : found.surface) {
    if (c.feature >= 8) continue;
    ++corners;
    EXPECT_GT(c.normal.z(), 0.999);
  }
  EXPECT_EQ(corners, 1);
}

// Deep, and near the line where the surface goes on flat: the way over that line is no way out.
TEST(ClosedSurface, ACornerNearTheEdgeBetweenFlatFacesIsHeld) {
  for (const double aside : {-0.03, -0.004, -1e-4, 1e-4, 0.004, 0.03}) {
    SurfaceWorld s;
    double deepest = 0;
    for (const SurfaceContact& c : corner_in(s, half, Vec3(0.2, 0.16 + aside, 0), 0.06).surface)
      if (c.normal.z() > 0.999) deepest = std::min(deepest, c.gap);
    EXPECT_NEAR(deepest, -0.06 - r, 1e-12) << aside;
  }
}

// A box beside the solid that overlaps it a little: out to the side, not over the top.
TEST(ClosedSurface, ABoxBesideIsPushedToTheSide) {
  SurfaceWorld s;
  s.add_closed_box(half, r, Vec3::Zero(), Mat3::Identity());
  s.add(box(0, Vec3::Constant(0.2), Vec3(0.7 - 0.003, 0.07, 0.2), Quat::Identity()));
  int touching = 0;
  for (const SurfaceContact& c : s.contacts().surface) {
    EXPECT_GT(c.gap, -0.01 - 2 * r) << c.feature << ": " << c.normal.transpose();
    touching += c.normal.x() > 0.999;
  }
  EXPECT_GT(touching, 0);
}

// The nodes of a thin plate are inside of its faces on the other side, as they should be.
TEST(ClosedSurface, AThinSolidDoesNotTouchItself) {
  SurfaceWorld s;
  s.add_closed_box(Vec3(0.5, 0.4, 0.015), r, Vec3::Zero(), Mat3::Identity());
  s.surfaces[0].self_collision = true;
  for (Body& node : s.bodies) node.properties.group = -1;
  s.settings.has_past = true;
  for (const double speed : {0.0, 2.0}) {  // along the plate, fast enough to be followed
    for (Body& node : s.bodies) node.state.velocity = Vec3(node.state.position.z() > 0 ? speed : 0, 0, 0);
    for (const SurfaceContact& c : s.contacts().surface) ADD_FAILURE() << c.gap << ": " << c.normal.transpose();
  }
}

}  // namespace
}  // namespace unibody::closed_surface_test
