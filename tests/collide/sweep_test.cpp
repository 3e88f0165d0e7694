#include "collide/sweep.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "collide/bodies.hpp"

namespace unibody::sweep_test {
namespace {

using namespace samples;

constexpr double h = 0.016;

// What the solver does with one frictionless contact against something immovable: the least change of velocity that keeps
// the linear gap from closing.
Vec3 stopped(const Vec3& velocity, const Pair& p, double side) {
  Vec3 v = velocity;
  for (const auto& point : p.points) {
    const double gap_at_end = point.gap + h * side * p.normal.dot(v);
    if (gap_at_end < 0) v -= side * p.normal * gap_at_end / h;
  }
  return v;
}

Body thrown(Body b, const Vec3& velocity) {
  b.state.velocity = velocity;
  return b;
}

TEST(Sweep, FastSphereDoesNotPassAThinWall) {
  Body wall = box(1, Vec3(1, 1, 0.001), Vec3::Zero());
  wall.properties.motion = Motion::fixed;
  Random random(1);
  for (int k = 0; k < 300; ++k) {
    Vec3 at(random(-0.3, 0.3), random(-0.3, 0.3), 0.5 + random(0, 0.4));
    const Vec3 v(random(-30, 30), random(-30, 30), -random(80, 200));  // up to 3 m a step: 300 radii
    const double cross = (at.z() - 0.011) / -v.z();
    if (std::abs(at.x() + cross * v.x()) > 0.9 || std::abs(at.y() + cross * v.y()) > 0.9) continue;
    const Pair p = collide_two(thrown(sphere(0, 0.01, at), v), wall, {});
    ASSERT_EQ(p.points.size(), 1u);
    EXPECT_LT((p.normal - Vec3::UnitZ()).norm(), 1e-7);
    const Vec3 end = at + h * stopped(v, p, 1);
    EXPECT_NEAR(end.z(), 0.011, 1e-7);
    EXPECT_NEAR(p.points[0].gap, at.z() - 0.011, 1e-7);
  }
}

TEST(Sweep, FastSphereMeetsASmallSphereWithTheNormalOfTheImpact) {
  const Vec3 v(100, 0, 0);
  const Pair p = collide_two(thrown(sphere(0, 0.01, Vec3(-1, 0.012, 0)), v), sphere(1, 0.01, Vec3::Zero()), {});
  ASSERT_EQ(p.points.size(), 1u);
  const double x = std::sqrt(0.0004 - 0.012 * 0.012);  // centre of the first at impact: (-x, .012, 0)
  EXPECT_LT((p.normal - Vec3(-x, 0.012, 0) / 0.02).norm(), 1e-12);
  EXPECT_NEAR(p.points[0].gap, (1 - x) * x / 0.02, 1e-12);
  // the linear gap closes exactly at the time of impact
  EXPECT_NEAR(p.points[0].gap + (1 - x) / 100 * p.normal.dot(v), 0, 1e-12);
}

TEST(Sweep, NearMissMakesNoContact) {
  const Vec3 v(100, 0, 0);
  for (const double miss : {0.0201, 0.03, 0.1})
    EXPECT_TRUE(collide_two(thrown(sphere(0, 0.01, Vec3(-0.8, miss, 0)), v), sphere(1, 0.01, Vec3::Zero()), {}).points.empty());
  EXPECT_FALSE(collide_two(thrown(sphere(0, 0.01, Vec3(-0.8, 0.0199, 0)), v), sphere(1, 0.01, Vec3::Zero()), {}).points.empty());
  // boxes and spheres alike
  EXPECT_TRUE(collide_two(thrown(sphere(0, 0.01, Vec3(-0.8, 0.1101, 0)), v), box(1, Vec3(0.1, 0.1, 0.1), Vec3::Zero()), {})
                  .points.empty());
  EXPECT_FALSE(collide_two(thrown(sphere(0, 0.01, Vec3(-0.8, 0.1099, 0)), v), box(1, Vec3(0.1, 0.1, 0.1), Vec3::Zero()), {})
                   .points.empty());
  const Quat turn(Eigen::AngleAxisd(0.4, Vec3(1, 1, 0).normalized()));
  const Body target = box(1, Vec3(0.1, 0.1, 0.1), Vec3::Zero(), turn);
  const double top = bounding_half_extents(target.properties.shape, turn).y() + 0.02;
  EXPECT_TRUE(collide_two(thrown(box(0, Vec3(0.02, 0.02, 0.02), Vec3(-0.8, top + 1e-4, 0)), v), target, {}).points.empty());
  // moving apart
  EXPECT_TRUE(collide_two(thrown(sphere(0, 0.01, Vec3(-0.5, 0, 0)), -v), sphere(1, 0.01, Vec3::Zero()), {}).points.empty());
  // beyond the step
  EXPECT_TRUE(collide_two(thrown(sphere(0, 0.01, Vec3(-1.7, 0, 0)), v), sphere(1, 0.01, Vec3::Zero()), {}).points.empty());
}

// Impact times of random pairs against small steps of the exact gap without motion.
TEST(Sweep, TimeOfImpactAgreesWithSmallSteps) {
  Random random(2);
  int hits = 0, misses = 0;
  for (int k = 0; k < 400; ++k) {
    const bool round_a = k % 3 == 0, round_b = k % 2 == 0;
    const auto make = [&](Id id, bool round, const Vec3& at) {
      return round ? sphere(id, random(0.05, 0.1), at) : box(id, random.vector(0.03, 0.1), at, random.turn());
    };
    const Vec3 from = random.turn() * Vec3(0.6, 0, 0);
    const Body a = make(0, round_a, from), b = make(1, round_b, Vec3::Zero());
    const Vec3 v = (random.vector(-0.15, 0.15) - from) * 100;  // 1.6 times the distance in a step
    const Pair p = collide_two(thrown(a, v), b, {});
    CollideSettings touching;
    touching.margin = 1e-3;
    double first = HUGE_VAL;
    for (int i = 0; i <= 2000 && first == HUGE_VAL; ++i) {
      Body moved = a;
      moved.state.position += i * h / 2000 * v;
      const Pair q = collide_two(moved, b, touching);
      if (!q.points.empty() && q.smallest_gap() <= 0) first = i * h / 2000;
    }
    if (first == HUGE_VAL) {
      // a contact may still be made if they touch just after the step, or graze
      ++misses;
      continue;
    }
    ++hits;
    ASSERT_FALSE(p.points.empty()) << k;
    const double closing = -p.normal.dot(v);
    ASSERT_GT(closing, 0) << k;
    EXPECT_NEAR(p.smallest_gap() / closing, first, 3 * h / 2000) << k;
  }
  EXPECT_GT(hits, 150);
  EXPECT_GT(misses, 20);
}

TEST(Sweep, FastBoxLandsOnItsWholeFace) {
  Body floor = box(1, Vec3(1, 1, 0.01), Vec3::Zero());
  floor.properties.motion = Motion::fixed;
  const Vec3 v(0, 0, -60);
  const Pair p = collide_two(thrown(box(0, Vec3(0.05, 0.05, 0.02), Vec3(0.1, 0.2, 0.53)), v), floor, {});
  ASSERT_EQ(p.points.size(), 4u);
  for (const auto& point : p.points) {
    EXPECT_NEAR(point.gap, 0.5, 1e-12);
    EXPECT_NEAR(point.position.z(), 0.01, 1e-12);  // where they will touch
  }
}

TEST(Sweep, TouchingPairsKeepTheirContactsHoweverFast) {
  const Vec3 v(0, 0, 60);  // leaving
  const Pair p = collide_two(thrown(sphere(0, 0.05, Vec3(0, 0, 0.0995)), v), sphere(1, 0.05, Vec3::Zero()), {});
  ASSERT_EQ(p.points.size(), 1u);
  EXPECT_NEAR(p.points[0].gap, -0.0005, 1e-12);
  const Pair slides = collide_two(thrown(box(0, Vec3(0.05, 0.05, 0.05), Vec3(0, 0, 0.1005)), Vec3(60, 0, 0)),
                                  box(1, Vec3(0.05, 0.05, 0.05), Vec3::Zero()), {});
  EXPECT_EQ(slides.points.size(), 4u);
}

}  // namespace
}  // namespace unibody::sweep_test
