// The guard by itself: what it holds apart, what it leaves alone, and that it keeps momentum.
#include <cmath>

#include "solve/guarded_world.hpp"

namespace unibody::surface_guard_test {
namespace {

using namespace samples;

constexpr double h = GuardedWorld::h, r = 0.01;  // s, m: the step and the radius of all nodes

// The mean velocity of the ends of a pair, towards which they are drawn.
Vec3 mean_of(const GuardedWorld& w, const std::vector<Vec3>& v, const std::vector<Id>& ends) {
  Vec3 sum = Vec3::Zero();
  double mass = 0;
  for (const Id id : ends) {
    const double m = w.bodies[static_cast<std::size_t>(id)].properties.mass;
    sum += m * v[static_cast<std::size_t>(id)], mass += m;
  }
  return sum / mass;
}

// One round holds the pair: all ends keep one share of their motion against the mean, less than all and more than nothing.
void expect_drawn_together(const GuardedWorld& w, const std::vector<Id>& ends) {
  const Vec3 mean = mean_of(w, w.solved, ends);
  double share = -1;
  for (const Id id : ends) {
    const auto i = static_cast<std::size_t>(id);
    const Vec3 before = w.solved[i] - mean, after = w.held[i] - mean;
    const double of_this = after.dot(before) / before.squaredNorm();
    if (share < 0) share = of_this;
    EXPECT_NEAR(of_this, share, 1e-12) << "body " << id;
    EXPECT_LT((after - of_this * before).norm(), 1e-12 * before.norm()) << "body " << id;
  }
  EXPECT_GT(share, 0);
  EXPECT_LT(share, 1);
}

void expect_momentum_is_kept(const GuardedWorld& w) {
  double size = 0;
  for (std::size_t i = 0; i < w.bodies.size(); ++i) size += w.bodies[i].properties.mass * w.solved[i].norm();
  EXPECT_LT((w.momentum(w.held) - w.momentum(w.solved)).norm(), 1e-14 * size);
  EXPECT_LE(w.kinetic_energy(w.held), w.kinetic_energy(w.solved) * (1 + 1e-14));
}

void expect_untouched(const GuardedWorld& w, Id first, Id nodes) {
  for (Id id = first; id < first + nodes; ++id)
    EXPECT_EQ(w.held[static_cast<std::size_t>(id)], w.solved[static_cast<std::size_t>(id)]) << "body " << id;
}

void expect_all_untouched(const GuardedWorld& w) {
  EXPECT_EQ(w.count, 0);
  expect_untouched(w, 0, static_cast<Id>(w.bodies.size()));
}

// A triangle of another surface, far beyond, that makes nobody's way cross: to see that it keeps its bits.
Id add_bystander(GuardedWorld& w) {
  const Id first = w.add_surface({{30, 0, 0}, {31, 0, 0}, {30, 1, 0}}, {{0, 1, 2}}, r);
  w.move(first, 3, Vec3(0.1, 1.0 / 3, -7));
  return first;
}

const std::array<Id, 3> face{0, 1, 2};

// The face of nodes 0 to 2 in the plane z = 0, and a thread's end, node 3, `above` it at (x, y), that the solve left heading down
// at `speed`; the thread's other node, 4, goes along high above.
struct NodeAndFace : GuardedWorld {
  Id bystander;
  NodeAndFace(double x, double y, double above, double speed) {
    add_surface({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}, r);
    add_surface({{x, y, above}, {x, y, above + 3}}, {{0, 1, 1}}, r);
    move(3, 2, Vec3(0, 0, -speed));
    bystander = add_bystander(*this);
  }
};

}  // namespace

TEST(SurfaceGuard, ANodeDoesNotPassAFace) {
  for (const double speed : {10.0, 100.0})
    for (const double mass : {0.01, 1.0, 100.0}) {
      NodeAndFace w(0.3, 0.2, 0.05, speed);
      w.set_mass(3, 1, mass);
      w.move(0, 3, Vec3(0, 0.5, 1));
      w.velocity(1) = Vec3(1, 0, 2);  // the face turns and stretches
      w.guard();
      ASSERT_TRUE(passes_face(w, w.solved, 3, face)) << "the motion would not lead through";
      EXPECT_FALSE(passes_face(w, w.held, 3, face)) << speed << ' ' << mass;
      EXPECT_EQ(w.count, 1);
      expect_drawn_together(w, {0, 1, 2, 3});
      expect_momentum_is_kept(w);
      expect_untouched(w, 4, 1);
      expect_untouched(w, w.bystander, 3);
    }
}

// The same from either side, wherever the pair is and however it moves as a whole: the outcome turns with it.
TEST(SurfaceGuard, DoesNotDependOnTheFrame) {
  Random random(3);
  for (int trial = 0; trial < 20; ++trial) {
    NodeAndFace w(0.3, 0.2, trial % 2 ? 0.05 : -0.05, trial % 2 ? 20 : -20);
    const Mat3 turn = random.turn().toRotationMatrix();
    const Vec3 shift = random.vector(-3, 3), drift = random.vector(-5, 5);
    NodeAndFace moved = NodeAndFace(0.3, 0.2, trial % 2 ? 0.05 : -0.05, trial % 2 ? 20 : -20);
    for (Body& b : moved.bodies)
      b.state.position = turn * b.state.position + shift, b.state.velocity = turn * b.state.velocity + drift;
    w.guard(), moved.guard();
    EXPECT_EQ(w.count, 1);
    EXPECT_EQ(moved.count, 1);
    EXPECT_FALSE(passes_face(moved, moved.held, 3, face));
    for (std::size_t i = 0; i < w.bodies.size(); ++i)
      EXPECT_LT((moved.held[i] - turn * w.held[i] - drift).norm(), 0.0002 / h) << "a hit is known to 0.2 mm of the way";
  }
}

TEST(SurfaceGuard, TwoEdgesDoNotPassEachOther) {
  for (const double speed : {5.0, 50.0})
    for (const double slope : {0.0, 0.3}) {
      GuardedWorld w;
      w.add_surface({{-0.5, 0, 0}, {0.5, 0, 0}}, {{0, 1, 1}}, r);
      w.add_surface({{0.1, -0.4, 0.03 - 0.4 * slope * 0.05}, {0.1, 0.5, 0.03 + 0.5 * slope * 0.05}}, {{0, 1, 1}}, r);
      w.move(2, 2, Vec3(0.5, 0.2, -speed));
      w.velocity(2).z() *= 0.8;
      w.set_mass(2, 1, 3);
      const Id bystander = add_bystander(w);
      w.guard();
      ASSERT_TRUE(edges_pass(w, w.solved, {0, 1}, {2, 3})) << "the motion would not lead through";
      EXPECT_FALSE(edges_pass(w, w.held, {0, 1}, {2, 3})) << speed << ' ' << slope;
      EXPECT_EQ(w.count, 1);
      expect_drawn_together(w, {0, 1, 2, 3});
      expect_momentum_is_kept(w);
      expect_untouched(w, bystander, 3);
    }
}

TEST(SurfaceGuard, ALooseSphereDoesNotPassAFace) {
  for (const double speed : {10.0, 100.0, 1000.0})
    for (const double mass : {0.01, 1.0, 100.0}) {
      GuardedWorld w;
      w.add_surface({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}, r);
      const Id ball = w.add(sphere(0, 0.04, Vec3(0.25, 0.3, 0.06)));
      w.set_mass(ball, 1, mass);
      w.velocity(ball) = Vec3(1, 0, -speed);
      const Id bystander = add_bystander(w);
      w.guard();
      ASSERT_TRUE(passes_face(w, w.solved, ball, face)) << "the motion would not lead through";
      EXPECT_FALSE(passes_face(w, w.held, ball, face)) << speed << ' ' << mass;
      EXPECT_EQ(w.count, 1);
      expect_drawn_together(w, {0, 1, 2, ball});
      expect_momentum_is_kept(w);
      expect_untouched(w, bystander, 3);
    }
}

// What is held stays: the other end is drawn towards the velocity of the held ones, which is not changed in a bit.
TEST(SurfaceGuard, HeldNodesStay) {
  for (const bool sphere_is_held : {false, true}) {
    GuardedWorld w;
    w.add_surface({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}, r);
    const Id ball = w.add(sphere(0, 0.04, Vec3(0.25, 0.3, 0.06)));
    if (sphere_is_held) {
      w[ball].properties.motion = Motion::kinematic;
      w.velocity(ball) = Vec3(0, 0, -20);
    } else {
      w.pinned = {0, 1, 2};
      w.move(0, 3, Vec3(0, 0, 2));
      w.velocity(ball) = Vec3(1, 0, -20);
    }
    w.guard();
    ASSERT_TRUE(passes_face(w, w.solved, ball, face));
    EXPECT_FALSE(passes_face(w, w.held, ball, face)) << sphere_is_held;
    EXPECT_EQ(w.count, 1);
    if (sphere_is_held) {
      expect_untouched(w, ball, 1);
      for (const Id id : face) EXPECT_LT(w.held[static_cast<std::size_t>(id)].z(), -5) << "pushed along";
    } else {
      expect_untouched(w, 0, 3);
      EXPECT_GT(w.held[static_cast<std::size_t>(ball)].z(), -20);
    }
  }
}

// A face whose nodes are all held turns, and takes along what lies in its way as fast as it is there.
TEST(SurfaceGuard, AHeldFaceMayTurn) {
  for (const double turn : {0.5, 2.0, 10.0, 20.0})  // rad/s, about the side at x = 0
    for (const Vec3& place : {Vec3(0.8, 0.1, 0.004), Vec3(0.3, 0.3, 0.001), Vec3(0.95, 0.02, 0.007)}) {
      GuardedWorld w;
      w.add_surface({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}, r);
      w.pinned = {0, 1, 2};
      w.velocity(1) = Vec3(0, 0, turn);
      const Id ball = w.add(sphere(0, 0.04, place));
      w.guard();
      EXPECT_FALSE(passes_face(w, w.held, ball, face)) << turn << ", from " << place.transpose();
      EXPECT_GE(w.count, 1);
      expect_untouched(w, 0, 3);
    }
}

// What nobody can move is nobody's to hold: it is neither changed nor counted.
TEST(SurfaceGuard, TwoHeldSidesAreLeftAlone) {
  GuardedWorld w;
  w.add_surface({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}, r);
  w.pinned = {0, 1, 2};
  const Id ball = w.add(sphere(0, 0.04, Vec3(0.25, 0.3, 0.06)));
  w[ball].properties.motion = Motion::kinematic, w.velocity(ball) = Vec3(0, 0, -20);
  w.guard();
  ASSERT_TRUE(passes_face(w, w.solved, ball, face));
  expect_all_untouched(w);
}

// What the solve itself has thrown at a face, though it stood still before.
TEST(SurfaceGuard, HoldsWhatTheSolveHasTurned) {
  NodeAndFace w(0.3, 0.2, 0.05, 100);
  w.before_solve.assign(w.bodies.size(), Vec3::Zero());
  w.guard();
  EXPECT_FALSE(passes_face(w, w.held, 3, face));
  EXPECT_EQ(w.count, 1);
  expect_drawn_together(w, {0, 1, 2, 3});
}

// Spheres at faces of any shape, by any motion, from near and far: what would pass is held; what is not held has its bits. Held
// nodes move as one.
TEST(SurfaceGuard, AnyPair) {
  Random random(17);
  int passing = 0, left_alone = 0;
  for (int trial = 0; trial < 1000; ++trial) {
    const auto size = [&](double low, double high) { return std::pow(10, random(low, high)); };
    GuardedWorld w;
    w.add_surface({random.vector(-0.5, 0.5), random.vector(-0.5, 0.5), random.vector(-0.5, 0.5)}, {{0, 1, 2}}, r);
    const double u = random(0, 0.7), v = random(0, 0.9 - u), speed = size(-1, 3);
    const auto corner = [&](Id k) { return w[k].state.position; };
    const Vec3 normal = (corner(1) - corner(0)).cross(corner(2) - corner(0)).normalized();
    const Vec3 aim = corner(0) + u * (corner(1) - corner(0)) + v * (corner(2) - corner(0));
    const Id ball = w.add(sphere(0, 0.02, aim + size(-5, -0.5) * normal + 0.1 * random.vector(-1, 1)));
    for (Id id = 0; id <= ball; ++id) {
      w.velocity(id) = speed * random.vector(-1, 1) - (id == ball ? speed : 0) * normal;
      w.set_mass(id, 1, size(-2, 2));
      if (id < ball && random(0, 1) < 0.2) w.pinned.push_back(id);
    }
    for (const Id id : w.pinned) w.velocity(id) = w.velocity(w.pinned[0]);
    w.guard();
    const bool would_pass = passes_face(w, w.solved, ball, face);
    passing += would_pass, left_alone += w.count == 0;
    ASSERT_FALSE(passes_face(w, w.held, ball, face)) << "trial " << trial;
    ASSERT_TRUE(!would_pass || w.count > 0) << "trial " << trial;
    if (w.count == 0) expect_all_untouched(w);
    for (const Id id : w.pinned) expect_untouched(w, id, 1);
    if (w.pinned.empty()) expect_momentum_is_kept(w);
  }
  EXPECT_GT(passing, 200);
  EXPECT_GT(left_alone, 200);
}

TEST(SurfaceGuard, WhatPassesBesideIsLeftAlone) {
  for (const Vec3& place : {Vec3(0.6, 0.6, 0.05), Vec3(-0.2, 0.5, 0.05), Vec3(0.5, -0.05, 0.05), Vec3(1.1, 0, 0.05)}) {
    NodeAndFace w(place.x(), place.y(), place.z(), 100);
    w.guard();
    expect_all_untouched(w);
  }
}

// Where it goes is over the face, but the face has gone by then.
TEST(SurfaceGuard, AFaceThatGetsOutOfTheWayIsLeftAlone) {
  NodeAndFace w(0.3, 0.2, 0.5, 40);  // at the face's plane after 0.8 of the step
  w.move(0, 3, Vec3(60, 0, 0));      // by then gone by 0.75 m
  w.guard();
  expect_all_untouched(w);
}

TEST(SurfaceGuard, WhatSeparatesIsLeftAlone) {
  for (const double above : {0.05, 0.011, 0.0021, 0.0001}) {
    NodeAndFace w(0.3, 0.2, above, -50);
    w.move(0, 3, Vec3(0, 0, -3));
    w.guard();
    expect_all_untouched(w);
  }
}

TEST(SurfaceGuard, WhatStopsShortIsLeftAlone) {
  NodeAndFace w(0.3, 0.2, 0.05, 0.04 / h);  // to 0.01 m above the face
  w.guard();
  expect_all_untouched(w);
}

// Nodes of one cloth that does not collide with itself, and a node with the faces that it belongs to.
TEST(SurfaceGuard, ASurfaceHoldsItselfOnlyIfItCollidesWithItself) {
  for (const bool itself : {false, true}) {
    GuardedWorld w;
    w.add_surface({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.2, 0.2, 0.05}, {0.2, 0.3, 2}, {0.3, 0.2, 2}}, {{0, 1, 2}, {3, 4, 5}}, r,
                  itself);
    w.move(3, 3, Vec3(0, 0, -10));
    w.guard();
    ASSERT_TRUE(passes_face(w, w.solved, 3, face));
    EXPECT_EQ(passes_face(w, w.held, 3, face), !itself);
    EXPECT_EQ(w.count, itself ? 1 : 0);
    if (!itself) expect_all_untouched(w);
  }
}

// Two spheres on two faces far from each other: two pairs, and each keeps its own momentum.
TEST(SurfaceGuard, CountsEachPairOnce) {
  GuardedWorld w;
  for (int k = 0; k < 2; ++k) {
    const Vec3 at(5.0 * k, 0, 0);
    w.add_surface({at, at + Vec3(1, 0, 0), at + Vec3(0, 1, 0)}, {{0, 1, 2}}, r);
  }
  for (int k = 0; k < 2; ++k) {
    const Id ball = w.add(sphere(0, 0.04, Vec3(5.0 * k + 0.25, 0.3, 0.06)));
    w.velocity(ball) = Vec3(1, 0, -30 * (k + 1));
  }
  w.guard();
  EXPECT_EQ(w.count, 2);
  expect_drawn_together(w, {0, 1, 2, 6});
  expect_drawn_together(w, {3, 4, 5, 7});
  expect_momentum_is_kept(w);
}

// Many pairs at once, each body in several: a sheet thrown at a sheet. Nothing passes, and no energy is made.
TEST(SurfaceGuard, HoldsASheetThrownAtASheet) {
  Random random(11);
  for (const double speed : {10.0, 100.0}) {
    GuardedWorld w;
    const Sheet lower = sheet(5, 5, 1, 1);
    Sheet upper = sheet(4, 4, 0.7, 0.7);
    for (Vec3& x : upper.nodes) x += Vec3(0.03, 0.02, 0.05) + random.vector(-0.01, 0.01);
    w.add_surface(lower.nodes, lower.cells, r);
    const Id first = w.add_surface(upper.nodes, upper.cells, r);
    for (Id id = first; id < first + 16; ++id) w.velocity(id) = Vec3(1, 0, -speed) + random.vector(-2, 2);
    w.guard();
    bool would_pass = false;
    for (const bool up : {true, false})
      for (const auto& cell : up ? upper.cells : lower.cells)
        for (Id node = up ? 0 : first; node < (up ? first : first + 16); ++node) {
          const std::array<Id, 3> ids{cell[0] + (up ? first : 0), cell[1] + (up ? first : 0), cell[2] + (up ? first : 0)};
          would_pass |= passes_face(w, w.solved, node, ids);
          ASSERT_FALSE(passes_face(w, w.held, node, ids)) << "node " << node << ", speed " << speed;
        }
    EXPECT_TRUE(would_pass);
    for (const SurfaceEdge& e : w.known->edges)
      for (const SurfaceEdge& f : w.known->edges) {
        if (e.surface >= f.surface) continue;
        const std::array<Id, 2> one{e.nodes[0], e.nodes[1]}, other{f.nodes[0], f.nodes[1]};
        ASSERT_FALSE(edges_pass(w, w.held, one, other)) << "edges, speed " << speed;
      }
    EXPECT_GT(w.count, 0);
    EXPECT_LE(w.kinetic_energy(w.held), w.kinetic_energy(w.solved) * (1 + 1e-12));
  }
}

}  // namespace unibody::surface_guard_test
