// The turns of a joint's ends, and angles less whole turns.
#include "joints/joint_side.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace unibody::joint_side_test {

TEST(JointSide, TurnedAxesAreThoseOfTheProduct) {
  std::mt19937 random(3);
  std::normal_distribution<double> number;
  for (int k = 0; k < 200; ++k) {
    const Quat q = Quat(number(random), number(random), number(random), number(random)).normalized();
    const Vec3 half = std::pow(10.0, k % 7 - 5) * Vec3(number(random), number(random), number(random));
    const Mat3 expected = Mat3((Quat(1, half.x(), half.y(), half.z()) * q).normalized());
    EXPECT_LT((turned_axes(q, half) - expected).cwiseAbs().maxCoeff(), 1e-14);
  }
  EXPECT_EQ(turned_axes(Quat::Identity(), Vec3::Zero()), Mat3(Mat3::Identity()));
}

TEST(JointSide, WrappedAnglesAreRemainders) {
  const auto expect = [](double angle) { EXPECT_EQ(wrapped(angle), std::remainder(angle, 2 * M_PI)) << angle; };
  for (const double turns : {0.0, 0.25, 0.5, 1.0, 1.5, 7.25})
    for (const double sign : {-1.0, 1.0}) {
      const double angle = sign * turns * 2 * M_PI;
      expect(angle), expect(std::nextafter(angle, 10)), expect(std::nextafter(angle, -10));
    }
  std::mt19937 random(4);
  std::uniform_real_distribution<double> any(-20, 20);
  for (int k = 0; k < 1000; ++k) expect(any(random));
}

}  // namespace unibody::joint_side_test
