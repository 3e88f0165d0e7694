// Hulls of points that lie in one plane but for the digits they are written with: as files of meshes have them.
#include "world/hull.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace unibody::hull_test {

namespace {

class RoundedPoints : public ::testing::TestWithParam<double> {};

// The lattice of 5 x 5 x 5 points of a block of 1 x 2 x 3 m, turned, rounded, in any order and some of them twice.
std::vector<Vec3> block(std::mt19937& random, double digit) {
  std::uniform_real_distribution<double> uniform(-1, 1);
  const Quat turn(Eigen::Vector4d(uniform(random), uniform(random), uniform(random), uniform(random)).normalized());
  std::vector<Vec3> points;
  for (int i = 0; i < 125; ++i) {
    const Vec3 x = turn * Vec3(0.25 * (i % 5), 0.5 * (i / 5 % 5), 0.75 * (i / 25));
    points.push_back((x / digit).array().round().matrix() * digit);
    if (i % 3 == 0) points.push_back(points.back());
  }
  std::shuffle(points.begin(), points.end(), random);
  return points;
}

// m^3, between the faces and the centre.
double volume_within_faces(const Hull& hull) {
  double volume = 0;
  for (const Hull::Face& face : hull.faces) {
    const auto corner = [&](std::uint32_t k) { return hull.corners[hull.face_corners[face.first + k]]; };
    for (std::uint32_t k = 1; k + 1 < face.count; ++k) volume += corner(0).dot(corner(k).cross(corner(k + 1))) / 6;
  }
  return volume;
}

}  // namespace

TEST_P(RoundedPoints, HaveTheHullOfTheBlock) {
  const double digit = GetParam();
  std::mt19937 random(7);
  for (int trial = 0; trial < 50; ++trial) {
    const Hull hull = make_hull(block(random, digit));
    // Each face may move by a digit; the block's area is 22 m^2.
    EXPECT_NEAR(hull.volume, 6, 22 * digit) << trial;
    EXPECT_NEAR(volume_within_faces(hull), 6, 22 * digit + 1e-5) << trial;  // points within 1e-7 of the extent are one face's
    Vec3 moments = hull.inertia;
    std::sort(moments.data(), moments.data() + 3);
    EXPECT_LT((moments - Vec3(1 + 4, 1 + 9, 4 + 9) / 12).norm(), 10 * digit) << trial;
    EXPECT_GE(hull.faces.size(), 6u);
    EXPECT_LE(hull.faces.size(), digit < 1e-7 ? 6u : 125u) << trial;
  }
}

INSTANTIATE_TEST_SUITE_P(Digits, RoundedPoints, ::testing::Values(1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12),
                         [](const auto& digit) { return "e" + std::to_string(-std::lround(std::log10(digit.param))); });

}  // namespace unibody::hull_test
