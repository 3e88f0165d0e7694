// The load of faces that spin goes to the inner ring, with the same force and moment.
#include "constraints/level_pressure.hpp"

#include <gtest/gtest.h>

namespace unibody::level_pressure_test {

namespace {

struct Case {
  Contacts contacts;
  Multipliers history;
  World world;
  std::vector<ContactBatch::Impulse> impulses;

  // A square of side 2 about (3, 4), and its ring of side 1.
  Case() {
    for (const double size : {1.0, 0.5}) {
      Manifold m{1, 2, 0, 1, Vec3::UnitZ(), 0.5, static_cast<std::uint32_t>(contacts.points.size()), 4};
      m.is_inner_ring = size < 1;
      contacts.manifolds.push_back(m);
      for (const Vec3& corner : {Vec3(1, 1, 0), Vec3(-1, 1, 0), Vec3(-1, -1, 0), Vec3(1, -1, 0)})
        contacts.points.push_back({Vec3(3, 4, 0) + size * corner, 0, 0});
    }
    impulses.resize(8, {0, 0, 0});
    world.homes = 2, world.resize(2);
    for (std::size_t slot = 0; slot < 2; ++slot) {
      Body body;
      body.id = static_cast<Id>(slot + 1);
      body.state.position = Vec3(3, 4, slot == 0 ? 1 : -1);
      if (slot == 0) body.state.angular_velocity = Vec3(0, 0, 500);
      world.set(slot, body);
    }
    history.begin_manifold(1, 2);
  }
  void remember(std::initializer_list<double> forces) {
    for (const double f : forces) history.points.push_back({f, Vec3::Zero()});
  }
  Vec3 force_and_moments() const {
    Vec3 sum = Vec3::Zero();
    for (std::size_t k = 0; k < 8; ++k) {
      const Vec3 arm = contacts.points[k].position - Vec3(3, 4, 0);
      sum += impulses[k].n * Vec3(1, arm.x(), arm.y());
    }
    return sum;
  }
};

}  // namespace

TEST(LevelPressure, KeepsForceAndMoment) {
  Case c;
  const double n[8] = {3, 2, 2.5, 2, 1, 0, 1, 0.5};
  for (std::size_t k = 0; k < 8; ++k) c.impulses[k] = {n[k], 0.1, 0.2};
  c.remember({12.0});
  const Vec3 before = c.force_and_moments();
  level_pressure(c.history, c.world, c.contacts, 1, c.impulses);
  EXPECT_LT((c.force_and_moments() - before).norm(), 1e-12);
  for (std::size_t k = 0; k < 4; ++k) EXPECT_EQ(c.impulses[k].n, 0) << "the rim keeps a part";
  for (std::size_t k = 4; k < 8; ++k) {  // the upper body turns from x to y
    const Vec3 arm = c.contacts.points[k].position - Vec3(3, 4, 0);
    const Vec3 s = first_tangent_of(Vec3::UnitZ()), t = Vec3::UnitZ().cross(s);
    const Vec3 friction = c.impulses[k].s * s + c.impulses[k].t * t;
    EXPECT_LT((friction - 0.5 * c.impulses[k].n * -Vec3::UnitZ().cross(arm.normalized())).norm(), 1e-12);
  }
  // linear in the place: the sums over both diagonals are the same
  EXPECT_NEAR(c.impulses[4].n + c.impulses[6].n, c.impulses[5].n + c.impulses[7].n, 1e-12);
}

// Points that are no more leave their part to those that are.
TEST(LevelPressure, TheForceIsAllThatIsRemembered) {
  Case c;
  for (std::size_t k = 0; k < 3; ++k) c.impulses[k] = {0.5, 0, 0};  // of four
  for (std::size_t k = 4; k < 8; ++k) c.impulses[k] = {0.5, 0, 0};
  c.remember({10, 10, 10, 10});
  level_pressure(c.history, c.world, c.contacts, 0.1, c.impulses);
  EXPECT_NEAR(c.force_and_moments()[0], 4, 1e-12);
}

// A ring whose points lie on a line, but for round-off, has no slope across it: what is off by 1e-18 m may not gain a load by it.
TEST(LevelPressure, ALineHasNoSlope) {
  Case c;
  for (std::size_t k = 4; k < 8; ++k) {
    c.contacts.points[k].position = Vec3(3 + 0.3 * static_cast<double>(k), 4 + 1e-16 * static_cast<double>(k * k), 0);
    c.impulses[k] = {0.5 + 0.1 * static_cast<double>(k), 0, 0};
  }
  c.remember({10.0});
  const auto before = c.impulses;
  level_pressure(c.history, c.world, c.contacts, 1, c.impulses);
  for (std::size_t k = 0; k < 8; ++k) EXPECT_EQ(c.impulses[k].n, before[k].n) << k;
}

// A surface that moves along itself is what the face above slides on.
TEST(LevelPressure, OnABelt) {
  Case c;
  c.world.set_state(0, {Vec3(3, 4, 1), Quat::Identity(), Vec3::Zero(), Vec3::Zero()});
  c.world.surface_motions = {{2, 1, Vec3(500, 0, 0), Vec3::Zero()}};
  for (std::size_t k = 0; k < 8; ++k) c.impulses[k] = {1, 0, 0};
  c.remember({8.0});
  level_pressure(c.history, c.world, c.contacts, 1, c.impulses);
  for (std::size_t k = 4; k < 8; ++k) {
    const Vec3 s = first_tangent_of(Vec3::UnitZ()), t = Vec3::UnitZ().cross(s);
    EXPECT_LT((c.impulses[k].s * s + c.impulses[k].t * t - 0.5 * 2 * Vec3::UnitX()).norm(), 1e-12) << k;
  }
}

TEST(LevelPressure, WhatWouldPullStays) {
  Case c;
  c.impulses[0] = {1, 0, 0};  // all at one corner of the rim
  c.remember({1.0});
  level_pressure(c.history, c.world, c.contacts, 1, c.impulses);
  EXPECT_EQ(c.impulses[0].n, 1);
  EXPECT_EQ(c.impulses[4].n, 0);
}

TEST(LevelPressure, OnlyOfPairsWithARing) {
  Case c;
  c.contacts.manifolds[1].is_inner_ring = false;
  c.impulses[0] = {1, 0, 0}, c.impulses[2] = {1, 0, 0};
  c.remember({1.0, 1.0});
  level_pressure(c.history, c.world, c.contacts, 1, c.impulses);
  EXPECT_EQ(c.impulses[0].n, 1);
}

}  // namespace unibody::level_pressure_test
