// The guard and boxes: no corner goes through a face, on the straight way between its places before and after the step.
#include "solve/free_motion.hpp"
#include "solve/guarded_world.hpp"
#include "world/shape_library.hpp"

namespace unibody::surface_guard_box_test {
namespace {

using namespace samples;

constexpr double h = GuardedWorld::h, r = 0.01;  // s, m: the step and the radius of all nodes
const std::array<Id, 3> face{0, 1, 2};

// A box of 0.3 x 0.2 x 0.15 m over a triangle in the plane z = 0 whose sides are 4 m long.
struct BoxOverFace : GuardedWorld {
  Id box, bystander;
  BoxOverFace(const Quat& turn, double above) {
    add_surface({{-1, -1, 0}, {3, -1, 0}, {-1, 3, 0}}, {{0, 1, 2}}, r);
    Body body = samples::body(0, ShapeKind::box, Vec3(0.15, 0.1, 0.075), Vec3(0.1, 0.2, above));
    body.state.orientation = turn;
    box = add(body);
    bystander = add_surface({{30, 0, 0}, {31, 0, 0}, {30, 1, 0}}, {{0, 1, 2}}, r);
    move(bystander, 3, Vec3(0.1, 1.0 / 3, -7));
  }

  // How many corners go through the face in a step with these velocities; where a step ends is for finish_motion to say.
  int corners_through(const std::vector<Vec3>& v) {
    const Body& b = (*this)[box];
    SolverBody moving{};
    Eigen::Map<Vec3>(moving.v) = v[static_cast<std::size_t>(box)], Eigen::Map<Vec3>(moving.w) = b.state.angular_velocity;
    BodyProperties free = b.properties;
    free.inertia = Vec3::Ones();
    const BodyState next = finish_motion(free, b.state, moving, Vec3::Zero(), h, false);
    int through = 0;
    for (int corner = 0; corner < 8; ++corner) {
      const Vec3 half = b.properties.shape.size;
      const Vec3 arm(corner & 1 ? half.x() : -half.x(), corner & 2 ? half.y() : -half.y(), corner & 4 ? half.z() : -half.z());
      through += passes(b.state.position + b.state.orientation * arm, next.position + next.orientation * arm, v);
    }
    return through;
  }

  bool passes(const Vec3& from, const Vec3& to, const std::vector<Vec3>& v) const {
    constexpr int samples = 4000;
    double before = 0;
    for (int i = 0; i <= samples; ++i) {
      const double t = static_cast<double>(i) / samples;
      const Vec3 p = from + t * (to - from), a = at(face[0], t, v), b = at(face[1], t, v), c = at(face[2], t, v);
      const double side = volume(a, b, c, p);
      const Vec3 n = (b - a).cross(c - a);
      const bool over = n.dot((b - a).cross(p - a)) >= 0 && n.dot((c - b).cross(p - b)) >= 0 && n.dot((a - c).cross(p - c)) >= 0;
      if (i > 0 && side * before <= 0 && over) return true;
      before = side;
    }
    return false;
  }
};

const Quat on_its_corner(Eigen::AngleAxisd(0.7, Vec3(1, -1, 0).normalized()));

TEST(SurfaceGuardBox, ACornerDoesNotPassAFace) {
  for (const double speed : {5.0, 50.0})
    for (const double mass : {0.01, 1.0, 100.0}) {
      BoxOverFace w(on_its_corner, 0.22);
      w.set_mass(w.box, 1, mass);
      w.velocity(w.box) = Vec3(0.3, 0, -speed);
      w.guard();
      ASSERT_GT(w.corners_through(w.solved), 0) << "the motion would not lead through";
      EXPECT_EQ(w.corners_through(w.held), 0) << speed << ' ' << mass;
      EXPECT_GT(w.count, 0);
      for (Id id = w.bystander; id < w.bystander + 3; ++id)
        EXPECT_EQ(w.held[static_cast<std::size_t>(id)], w.solved[static_cast<std::size_t>(id)]);
    }
}

// The same of two halves that make up the box: their centres and the whole's stay on their side of the face.
TEST(SurfaceGuardBox, ACornerOfACompoundDoesNotPassAFace) {
  const Shape half{ShapeKind::box, {0.075, 0.1, 0.075}};
  const Compound::Part halves[] = {{half, Vec3(-0.075, 0, 0), Quat::Identity()}, {half, Vec3(0.075, 0, 0), Quat::Identity()}};
  const Compound whole = make_compound(halves);
  BoxOverFace w(on_its_corner * whole.frame, 0.22);
  w[w.box].properties.shape = shape_library().add(whole);
  w.velocity(w.box) = Vec3(0.3, 0, -5);
  w.guard();
  ASSERT_EQ(w.corners_through(w.solved), 1);
  EXPECT_EQ(w.corners_through(w.held), 0);
  EXPECT_EQ(w.count, 1);
  EXPECT_LT((w.momentum(w.held) - w.momentum(w.solved)).norm(), 1e-13);
}

// One corner: the momentum of what it meets is the momentum that it loses.
TEST(SurfaceGuardBox, OneCornerKeepsTheMomentum) {
  BoxOverFace w(on_its_corner, 0.22);
  w.velocity(w.box) = Vec3(0.3, 0, -5);
  w[w.box].state.angular_velocity = Vec3(1, 2, 3);
  w.guard();
  ASSERT_EQ(w.corners_through(w.solved), 1);
  EXPECT_EQ(w.count, 1);
  EXPECT_NE(w.held[static_cast<std::size_t>(w.box)], w.solved[static_cast<std::size_t>(w.box)]);
  EXPECT_LT((w.momentum(w.held) - w.momentum(w.solved)).norm(), 1e-13);
}

// A corner that only turning leads through, where the box's centre stands still.
TEST(SurfaceGuardBox, TurningCountsAsWell) {
  BoxOverFace w(Quat::Identity(), 0.08);
  w[w.box].state.angular_velocity = Vec3(0, 20, 0);
  w.guard();
  ASSERT_GT(w.corners_through(w.solved), 0);
  EXPECT_EQ(w.corners_through(w.held), 0);
  EXPECT_GT(w.count, 0);
}

TEST(SurfaceGuardBox, WhatStaysApartIsLeftAlone) {
  BoxOverFace w(on_its_corner, 0.4);
  w.velocity(w.box) = Vec3(0.3, 0, -5);
  w[w.box].state.angular_velocity = Vec3(1, 2, 3);
  w.guard();
  ASSERT_EQ(w.corners_through(w.solved), 0);
  EXPECT_EQ(w.count, 0);
  EXPECT_EQ(w.held, w.solved);
}

}  // namespace
}  // namespace unibody::surface_guard_box_test
