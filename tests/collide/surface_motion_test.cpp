// Contacts of surfaces that depend on motion: sides that are kept, and what is fast enough to pass through within the step.
#include <gtest/gtest.h>

#include "collide/surface_world.hpp"

namespace unibody::surface_motion_test {
namespace {

using namespace samples;

constexpr double h = 0.016, r = 0.01;  // s, m: the step and the radius of all nodes

// Contacts of the body or node `id` with faces.
std::vector<SurfaceContact> contacts_of_body(SurfaceWorld& s, Id id) {
  std::vector<SurfaceContact> found;
  for (const SurfaceContact& c : s.contacts().surface)
    if (c.ids[0] == id && c.feature != 1000) found.push_back(c);
  return found;
}

// One triangle in the plane z = 0, large, and a node of another surface, whose face stands upright upon it.
struct NodeAtFace {
  SurfaceWorld s;
  Id node;
  explicit NodeAtFace(const Vec3& at, const Vec3& velocity) {
    s.add_surface({{-5, -5, 0}, {10, -5, 0}, {-5, 10, 0}}, {{0, 1, 2}}, r);
    const double up = at.z() < 0 ? -1 : 1;
    node = s.add_surface({at, at + Vec3(-50, 0, up * 50), at + Vec3(50, 0, up * 50)}, {{0, 1, 2}}, r);
    for (Id id = node; id < node + 3; ++id) s[id].state.velocity = velocity;
    s.settings.step = h;
  }
};

// All by the same motion: neither a common velocity nor a turn of everything changes what is found.
struct Frame {
  Mat3 turn;
  Vec3 shift, velocity;
  void apply(SurfaceWorld& s) const {
    for (Body& b : s.bodies) {
      b.state.position = turn * b.state.position + shift;
      b.state.velocity = turn * b.state.velocity + velocity;
      b.state.orientation = Quat(turn) * b.state.orientation;
    }
  }
};
std::vector<Frame> frames() {
  Random random(5);
  std::vector<Frame> all{{Mat3::Identity(), Vec3::Zero(), Vec3::Zero()}};
  for (int k = 0; k < 6; ++k)
    all.push_back(
        {random.turn().toRotationMatrix(), random.vector(-1, 1), k % 2 ? random.vector(-300, 300) : Vec3(Vec3::Zero())});
  return all;
}

}  // namespace

// A node that is `depth` below a face and was above it a step ago is told to go back; without a past, or if it was below before
// as well, it stays where it is.
TEST(SurfaceSides, ANodeThatPassedAFaceIsSentBack) {
  for (const Frame& frame : frames())
    for (const double depth : {0.001, 0.015, 0.03, 0.075})
      for (const double above : {0.002, 0.01, 1.0})  // the last: far faster than what is followed along the step
        for (const bool has_past : {true, false})
          for (const bool passed : {true, false}) {
            NodeAtFace t(Vec3(0.3, 0.2, -depth), Vec3(1, 2, passed ? -(depth + above) / h : 0));
            for (Id id = 0; id < 3; ++id) t.s[id].state.velocity = Vec3(1, 2, 0);  // the face goes along
            frame.apply(t.s);
            t.s.settings.has_past = has_past;
            if (!has_past || !passed) t.s.settings.margin = 1;  // to be found at all
            const auto found = contacts_of_body(t.s, t.node);
            ASSERT_EQ(found.size(), 1u);
            const bool back = has_past && passed;
            const SurfaceContact& c = found[0];
            ASSERT_EQ(c.ids[0], t.node);
            EXPECT_LT((c.normal - (back ? 1 : -1) * frame.turn.col(2)).norm(), 1e-11);
            EXPECT_NEAR(c.gap, back ? -depth - 2 * r : depth - 2 * r, 1e-12);
            if (back) {
              EXPECT_GT(c.beyond, depth);
              EXPECT_LT(c.beyond, depth + 2 * r);
            } else {
              EXPECT_EQ(c.beyond, 0);
            }
          }
}

TEST(SurfaceSides, ABallWhoseCentrePassedAFaceIsSentBack) {
  for (const bool has_past : {true, false}) {
    SurfaceWorld s;
    s.add_surface({{-5, -5, 0}, {10, -5, 0}, {-5, 10, 0}}, {{0, 1, 2}}, r);
    Body b = sphere(0, 0.1, Vec3(0, 0, -0.02));
    b.state.velocity.z() = -3;  // 4.8 cm in the step, less than its radius
    const Id id = s.add(b);
    s.settings.has_past = has_past, s.settings.step = h;
    const auto found = contacts_of_body(s, id);
    ASSERT_EQ(found.size(), 1u);
    EXPECT_EQ(found[0].normal, (has_past ? 1 : -1) * Vec3::UnitZ());
    EXPECT_NEAR(found[0].gap, (has_past ? -0.02 : 0.02) - 0.1 - r, 1e-15);
    EXPECT_LT((s.place(found[0].slots[0]) + found[0].arm - Vec3(0, 0, 0)).norm(), 1e-15) << "the arm ends on the face";
  }
}

TEST(SurfaceSides, EdgesThatPassedEachOtherAreSentBack) {
  for (const Frame& frame : frames())
    for (const double depth : {0.001, 0.03})
      for (const bool has_past : {true, false}) {
        SurfaceWorld s;  // two tents that point at each other
        s.add_surface({{-1, 0, 0}, {1, 0, 0}, {0, 4, -9}, {0, -4, -9}}, {{0, 1, 2}, {1, 0, 3}}, r);
        const Id upper = s.add_surface({{0, -1, 0}, {0, 1, 0}, {4, 0, 9}, {-4, 0, 9}}, {{0, 1, 2}, {1, 0, 3}}, r);
        for (Id id = upper; id < upper + 4; ++id) {
          s[id].state.position.z() -= depth;
          s[id].state.velocity.z() = -(depth + 0.01) / h;
        }
        frame.apply(s);
        s.settings.has_past = has_past, s.settings.step = h;
        const Contacts all = s.contacts();
        const SurfaceContact* found = nullptr;
        for (const SurfaceContact& c : all.surface)
          if (c.feature == 1000 && c.ids == std::array<Id, 4>{0, 1, upper, upper + 1}) found = &c;
        if (!has_past) {
          EXPECT_FALSE(found) << "no ridges towards each other";
          continue;
        }
        ASSERT_TRUE(found) << depth;
        EXPECT_LT((found->normal + frame.turn.col(2)).norm(), 1e-11);  // from the upper to the lower
        EXPECT_NEAR(found->gap, -depth - 2 * r, 1e-12);
        EXPECT_GT(found->beyond, depth);
      }
}

// A sharp fold along y, open upwards: who was in it and is below its edge now goes back; who went around the edge of a single
// face may stay. Whichever node of a face is its first.
TEST(SurfaceSides, PassingAnEdgeIsPassingThroughOnlyWithFacesOnBothSides) {
  for (int first = 0; first < 3; ++first)
    for (const bool fold : {true, false}) {
      SurfaceWorld s;
      Cells cells{{0, 1, 2}, {1, 0, 3}};
      if (!fold) cells.pop_back();
      for (auto& cell : cells) std::rotate(cell.begin(), cell.begin() + first, cell.end());
      std::vector<Vec3> nodes{{0, -1, 0}, {0, 1, 0}, {1, 0, 2}};
      if (fold) nodes.emplace_back(-1, 0, 2);
      s.add_surface(nodes, cells, r);
      const Id node = s.add_surface({{0, 0, -0.005}, {-.1, 0, -1}, {.1, 0, -1}}, {{0, 1, 2}}, r);
      s[node].state.velocity = Vec3(fold ? 0 : 0.3, 0, -1) * (0.01 / h);
      s.settings.has_past = true, s.settings.step = h;
      const auto found = contacts_of_body(s, node);
      ASSERT_EQ(found.size(), 1u) << first;
      EXPECT_EQ(found[0].normal, (fold ? 1 : -1) * Vec3::UnitZ()) << first;
      EXPECT_NEAR(found[0].gap, (fold ? -0.005 : 0.005) - 2 * r, 1e-16) << first;
    }
}

// Through a face at any speed and slant: in contact, with the normal of the side that it comes from and the way that it may go.
TEST(SurfaceMotion, AFastNodeBallOrBoxMeetsTheFace) {
  Random random(6);
  for (const Frame& frame : frames())
    for (const double speed : {10.0, 100.0, 1000.0})
      for (const double share : {0.05, 0.5, 0.95})  // of the step, after which they touch
        for (const double side : {1.0, -1.0})
          for (const int kind : {0, 1, 2}) {
            const double slant = random(0, 1), size = kind == 0 ? r : kind == 1 ? 0.05 : 0.04;
            const Vec3 velocity = speed * Vec3(std::sin(slant), 0, -side * std::cos(slant));
            const double gap = share * h * std::abs(velocity.z());
            const Vec3 at(-share * h * velocity.x(), 0.2, side * (gap + size + r));
            NodeAtFace t(kind == 0 ? at : Vec3(1000, 0, 1), velocity);
            Id id = t.node;
            if (kind != 0) {
              Body b = kind == 1 ? sphere(0, size, at) : box(0, Vec3(0.04, 0.05, size), at);
              b.state.velocity = velocity;
              id = t.s.add(b);
            }
            frame.apply(t.s);
            const auto found = contacts_of_body(t.s, id);
            ASSERT_EQ(found.size(), kind == 2 ? 4u : 1u) << kind << ' ' << speed << ' ' << share << ' ' << slant;
            for (const SurfaceContact& c : found) {
              EXPECT_LT((c.normal - side * frame.turn.col(2)).norm(), 1e-9);
              EXPECT_NEAR(c.gap, gap, 1e-11 * (1 + 300 * h)) << kind;
              EXPECT_EQ(c.beyond, 0);
              double sum = 0;
              for (const double weight : c.weights) sum += weight;
              EXPECT_NEAR(sum, 0, 1e-14);
              if (kind == 1) {
                EXPECT_NEAR(c.arm.norm(), size + r, 2e-6 + 2e-3 * (size + r)) << "as it touches";
              }
            }
          }
}

// Beside the face, short of it, or away from it: no contact.
TEST(SurfaceMotion, WhatPassesByHasNoContact) {
  for (const Frame& frame : frames())
    for (const double speed : {10.0, 100.0, 1000.0})
      for (const int kind : {0, 1, 2})
        for (const int way : {0, 1, 2}) {
          const double size = kind == 0 ? r : 0.05, gap = 0.5 * h * speed;
          Vec3 at(way == 0 ? -5 - size - r - 0.01 : 0, 0.2, gap + size + r), velocity(0, 0, -speed);
          if (way == 1) at.z() = 1.01 * h * speed + size + r + 0.01;
          if (way == 2) at.z() = 0.01 + size + r, velocity.z() = speed;
          NodeAtFace t(kind == 0 ? at : Vec3(1000, 0, 1), velocity);
          Id id = t.node;
          if (kind != 0) {
            Body b = kind == 1 ? sphere(0, size, at) : box(0, Vec3(0.05, 0.05, size), at);
            b.state.velocity = velocity;
            id = t.s.add(b);
          }
          frame.apply(t.s);
          // Both may be stopped by others within the step; along a common velocity the margin is that of the faster.
          if (way != 1 || frame.velocity.isZero()) {
            EXPECT_TRUE(contacts_of_body(t.s, id).empty()) << kind << ' ' << speed << ' ' << way;
          }
        }
}

// Edges across each other at 10 to 1000 m/s.
TEST(SurfaceMotion, FastEdgesMeet) {
  for (const Frame& frame : frames())
    for (const double speed : {10.0, 100.0, 1000.0})
      for (const bool beside : {false, true}) {
        const double gap = 0.4 * h * speed;
        SurfaceWorld s;
        s.add_surface({{-1, 0, 0}, {1, 0, 0}, {0, 4, -9}, {0, -4, -9}}, {{0, 1, 2}, {1, 0, 3}}, r);
        const Id upper = s.add_surface({{0, -1, 0}, {0, 1, 0}, {4, 0, 9}, {-4, 0, 9}}, {{0, 1, 2}, {1, 0, 3}}, r);
        for (Id id = upper; id < upper + 4; ++id) {
          s[id].state.position += Vec3(beside ? 6 : 0.5, 0, gap + 2 * r);
          s[id].state.velocity.z() = -speed;
        }
        frame.apply(s);
        s.settings.step = h;
        const Contacts all = s.contacts();
        int found = 0;
        for (const SurfaceContact& c : all.surface) {
          if (c.feature != 1000 || c.ids != std::array<Id, 4>{0, 1, upper, upper + 1}) continue;
          ++found;
          EXPECT_NEAR(c.gap, gap, 1e-11 * (1 + 300 * h));
          EXPECT_LT((c.normal + frame.turn.col(2)).norm(), 1e-9);
          EXPECT_NEAR(c.weights[0], 0.25, 1e-9);
          EXPECT_NEAR(c.weights[2], -0.5, 1e-9);
        }
        EXPECT_EQ(found, beside ? 0 : 1) << speed;
      }
}

// A face that is thrown at a ball at rest.
TEST(SurfaceMotion, AFastFaceMeetsABallAtRest) {
  SurfaceWorld s;
  s.add_surface({{-5, -5, 1}, {10, -5, 1}, {-5, 10, 1}}, {{0, 1, 2}}, r);
  for (Id id = 0; id < 3; ++id) s[id].state.velocity.z() = -200;
  const Id id = s.add(sphere(0, 0.05, Vec3::Zero()));
  s.settings.step = h;
  const auto found = contacts_of_body(s, id);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_LT((found[0].normal + Vec3::UnitZ()).norm(), 1e-12);
  EXPECT_NEAR(found[0].gap, 1 - 0.05 - r, 1e-12);
}

}  // namespace unibody::surface_motion_test
