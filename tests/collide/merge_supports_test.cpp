// The few points on which a body of many parts lies, against all of them.
#include "collide/merge_supports.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace unibody::merge_supports_test {
namespace {

constexpr double margin = 0.002;  // m

PairManifold manifold(const Vec3& normal, const std::vector<ContactPoint>& points, double time = 0) {
  PairManifold m;
  m.normal = normal, m.time = time;
  for (const ContactPoint& p : points) m.add(p.position, p.gap, p.feature);
  return m;
}

double lowest(const PairManifold& m, const Vec3& slope) {
  double result = HUGE_VAL;
  for (int i = 0; i < m.count; ++i) result = std::min(result, m.points[i].gap + slope.dot(m.points[i].position));
  return result;
}

}  // namespace

// A bowl-shaped underside in pieces: whatever the tilt, the lowest of the points kept is near the lowest of all. A tilt is at
// most 0.45 from one of those that were looked at, of length 0, 1/8 and 1; each point moves by the margin for a tilt of 1.
TEST(MergeSupports, TheLowestAreKeptAtEveryTilt) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (int round = 0; round < 50; ++round) {
    std::vector<PairManifold> all, merged;
    double reach = 0;
    for (int piece = 0; piece < 12; ++piece) {
      std::vector<ContactPoint> points;
      for (std::uint32_t k = 0; k < 5; ++k) {
        const Vec3 at(0.1 * unit(random), 0.05 * unit(random), 0);
        reach = std::max(reach, 2 * at.norm());  // from the mean of the points, wherever that is
        points.push_back({at, 0.1 * at.squaredNorm() + 1e-4 * unit(random), k});
      }
      all.push_back(manifold(Vec3::UnitZ(), points));
    }
    merged = all;
    merge_supports(merged, {margin});
    ASSERT_EQ(merged.size(), 1u);
    ASSERT_LE(merged[0].count, PairManifold::kept);
    ASSERT_GE(merged[0].count, 3);
    for (int k = 0; k < 200; ++k) {
      const double angle = M_PI * unit(random), size = std::abs(unit(random));
      const Vec3 slope = size * margin / reach * Vec3(std::cos(angle), std::sin(angle), 0);
      double of_all = HUGE_VAL;
      for (const PairManifold& m : all) of_all = std::min(of_all, lowest(m, slope));
      EXPECT_LE(lowest(merged[0], slope) - of_all, 2 * 0.45 * margin) << round << ' ' << k;
      EXPECT_GE(lowest(merged[0], slope), of_all);
    }
  }
}

// Of a body that turns in the step by a known angle, the point that comes down furthest is kept, however far that is beyond the
// margin: it was lost where others stood for it at smaller tilts.
TEST(MergeSupports, WhatATurnBringsDownIsKept) {
  std::mt19937 random(8);
  std::uniform_real_distribution<double> unit(-1, 1);
  int beyond = 0;
  for (int round = 0; round < 200; ++round) {
    std::vector<PairManifold> all, merged;
    for (int piece = 0; piece < 6; ++piece) {
      std::vector<ContactPoint> points;
      for (std::uint32_t k = 0; k < 5; ++k) {
        const Vec3 at(0.1 * unit(random), 0.1 * unit(random), 0);
        points.push_back({at, 2 * at.squaredNorm() + 1e-4 * unit(random), k});
      }
      all.push_back(manifold(Vec3::UnitZ(), points));
    }
    const Vec3 turn = 0.4 * Vec3(unit(random), unit(random), unit(random)), slope = Vec3::UnitZ().cross(turn);
    double of_all = HUGE_VAL, of_small = HUGE_VAL;
    for (const PairManifold& m : all) of_all = std::min(of_all, lowest(m, slope));
    merged = all;
    merge_supports(merged, {margin});
    of_small = lowest(merged[0], slope);
    merged = all;
    merge_supports(merged, {margin, 0, turn});
    ASSERT_LE(merged[0].count, PairManifold::kept);
    EXPECT_LT(lowest(merged[0], slope) - of_all, margin) << round;
    beyond += of_small - of_all > margin;
  }
  EXPECT_GT(beyond, 50);  // what the turn is asked for
}

// Of a flat underside the corners alone, each once, though pieces share them, and each as it was.
TEST(MergeSupports, OfAFlatUndersideItsCornersAreKept) {
  std::vector<PairManifold> pieces;
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 3; ++j) {
      std::vector<ContactPoint> points;
      for (const auto& [x, y] : {std::pair(0, 0), {1, 0}, {1, 1}, {0, 1}})
        points.push_back({Vec3(0.1 * (i + x), 0.1 * (j + y), 0), 1e-5, static_cast<std::uint32_t>(points.size())});
      pieces.push_back(manifold(Vec3::UnitZ(), points));
    }
  merge_supports(pieces, {margin});
  ASSERT_EQ(pieces.size(), 1u);
  ASSERT_EQ(pieces[0].count, 4);
  for (int i = 0; i < 4; ++i) {
    const ContactPoint& p = pieces[0].points[i];
    EXPECT_EQ(p.gap, 1e-5);
    EXPECT_TRUE(p.position.x() == 0 || p.position.x() == 0.4) << p.position.transpose();
    EXPECT_TRUE(p.position.y() == 0 || p.position.y() == 0.1 * 3) << p.position.transpose();
    EXPECT_TRUE(i == 0 || pieces[0].points[i - 1].feature < p.feature);
  }
}

// What has a normal of its own, or comes later in the step, stays; what is joined stands where the first of it stood.
TEST(MergeSupports, OtherNormalsAndLaterTimesStay) {
  const ContactPoint a{Vec3(0, 0, 0), 0, 0}, b{Vec3(1, 0, 0), 0, 1};
  const Vec3 up = Vec3::UnitZ(), aside = Vec3(1e-3, 0, 1).normalized();
  std::vector<PairManifold> all{manifold(aside, {a}), manifold(up, {a}), manifold(up, {b}, 0.001), manifold(aside, {b}),
                                manifold(up, {b})};
  merge_supports(all, {margin});
  ASSERT_EQ(all.size(), 3u);
  EXPECT_EQ(all[0].normal, aside);
  EXPECT_EQ(all[0].count, 2);
  EXPECT_EQ(all[1].normal, up);
  EXPECT_EQ(all[1].count, 2);
  EXPECT_EQ(all[2].time, 0.001);
  EXPECT_EQ(all[2].count, 1);
}

}  // namespace unibody::merge_supports_test
