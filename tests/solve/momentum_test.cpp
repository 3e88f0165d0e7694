#include "solve/momentum.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace unibody::momentum_test {

namespace {
SweepSums sums(std::int64_t gradient, std::int64_t progress) {
  SweepSums s;
  s.gradient = gradient, s.progress = progress;
  return s;
}
}  // namespace

// Nesterov's sequence: theta' = theta (sqrt(theta^2 + 4) - theta) / 2, beta = theta (1 - theta) / (theta^2 + theta'), theta_1
// = 1.
TEST(Momentum, BeginsWithTheKnownFactors) {
  Momentum m(Acceleration::nesterov);
  EXPECT_EQ(m.next({}, false).momentum, 0);
  EXPECT_NEAR(m.next(sums(-1, 100), true).momentum, 0.28175, 1e-5);
  EXPECT_NEAR(m.next(sums(-1, 90), true).momentum, 0.43404, 5e-6);
  EXPECT_EQ(m.restarts(), 0);
}

// theta_{k+1}^2 = (1 - theta_{k+1}) theta_k^2 is what the formula solves; beta then tends to 1 - 3/k.
TEST(Momentum, SolvesNesterovsRecursion) {
  Momentum m(Acceleration::nesterov);
  double theta = 1;
  for (int k = 0; k < 1000; ++k) {
    const double beta = m.next({}, false).momentum;
    double low = 0, high = 1;
    for (int i = 0; i < 100; ++i) {
      const double x = 0.5 * (low + high);
      (x * x < (1 - x) * theta * theta ? low : high) = x;
    }
    EXPECT_NEAR(beta, theta * (1 - theta) / (theta * theta + low), 1e-12);
    theta = low;
  }
  EXPECT_NEAR(m.next({}, false).momentum, 1 - 3.0 / 1001, 1e-4);
}

// On a quadratic of curvature `curvature` (largest: 1), by the recursion of Kim and Fessler's OGM1 with growing t = 1 / theta.
double published(double curvature, int iterations) {
  double t = 1, y = 1, z = 1;
  for (int k = 0; k < iterations; ++k) {
    const double next = 0.5 * (1 + std::sqrt(1 + 4 * t * t)), new_y = z - curvature * z;
    z = new_y + (t - 1) / next * (new_y - y) + overshoot_share * t / next * (new_y - z);
    t = next, y = new_y;
  }
  return y;
}

double by_momentum(Acceleration acceleration, double curvature, int iterations) {
  Momentum m(acceleration);
  double y = 1, z = 1;
  for (int k = 0; k < iterations; ++k) {
    const Extrapolation beyond = m.next({}, false);
    const double new_y = z - curvature * z;
    z = new_y + beyond.momentum * (new_y - y) + beyond.overshoot * (new_y - z);
    y = new_y;
  }
  return y;
}

TEST(Momentum, OptimizedIsThePublishedMethod) {
  for (const double curvature : {1.0, 0.3, 0.01, 1e-4})
    for (const int k : {1, 2, 3, 10, 100})
      EXPECT_NEAR(by_momentum(Acceleration::optimized, curvature, k), published(curvature, k), 1e-12) << curvature << ' ' << k;
}

// A mode too soft to turn round in k iterations: 1 - c k^2 (1 + s) / 8 is left of it, s the share of the overshoot.
TEST(Momentum, OptimizedTakesASoftModeFurther) {
  constexpr double soft = 1e-9;
  constexpr int k = 1000;
  EXPECT_NEAR((1 - by_momentum(Acceleration::nesterov, soft, k)) / (soft * k * k), 0.125, 0.002);
  EXPECT_NEAR((1 - by_momentum(Acceleration::optimized, soft, k)) / (soft * k * k), (1 + overshoot_share) / 8, 0.005);
}

// Modes beyond the bound on the curvature die out up to 1 + (1 - s) / (3 + s), and grow further on.
TEST(Momentum, BearsCurvatureALittleBeyondItsBound) {
  for (const Acceleration acceleration : {Acceleration::optimized, Acceleration::nesterov}) {
    const double s = acceleration == Acceleration::optimized ? overshoot_share : 0, room = (1 - s) / (3 + s);
    EXPECT_LT(std::abs(by_momentum(acceleration, 1 + 0.8 * room, 2000)), 1e-3);
    EXPECT_GT(std::abs(by_momentum(acceleration, 1 + 1.2 * room, 2000)), 1e3);
  }
}

// Cold steps at position level are stable where the iterations leave more than -1/3 of each mode. Both leave -.132 at least.
TEST(Momentum, LeavesNoModeFurtherBeyondThanASeventh) {
  for (const Acceleration acceleration : {Acceleration::optimized, Acceleration::nesterov}) {
    double least = 0;
    for (int k = 1; k <= 400; k = k < 20 ? k + 1 : k * 21 / 20)
      for (double curvature = 1e-5; curvature <= 1; curvature *= 1.02)
        least = std::min(least, by_momentum(acceleration, curvature, k));
    EXPECT_GT(least, -0.1323 - 1e-3);
    EXPECT_LT(least, -0.12);
  }
}

TEST(Momentum, RestartsUphill) {
  Momentum m(Acceleration::nesterov);
  for (int k = 0; k < 5; ++k) m.next(sums(-1, 10), true);
  EXPECT_EQ(m.next(sums(1, 10), true).momentum, 0);
  EXPECT_EQ(m.restarts(), 1);
  EXPECT_EQ(m.next(sums(-1, 10), true).momentum, 0);  // theta is 1 again
  EXPECT_NEAR(m.next(sums(-1, 10), true).momentum, 0.28175, 1e-5);
}

TEST(Momentum, RestartsWhereTheStepIsTwiceTheSmallest) {
  Momentum m(Acceleration::nesterov);
  for (int k = 0; k < 5; ++k) m.next(sums(-1, 100 - k), true);
  EXPECT_GT(m.next(sums(-1, 4 * 96), true).momentum, 0);  // not more than twice in length
  EXPECT_EQ(m.next(sums(-1, 4 * 96 + 1), true).momentum, 0);
  EXPECT_EQ(m.next(sums(-1, 4 * 96 + 1), true).momentum, 0);  // theta is 1; the bar has been raised, so this is no restart
  EXPECT_EQ(m.restarts(), 1);
}

TEST(Momentum, IgnoresSumsThatAreNotValid) {
  Momentum m(Acceleration::nesterov);
  m.next(sums(1, 1), false);
  EXPECT_GT(m.next(sums(1, 1 << 20), false).momentum, 0);
  EXPECT_EQ(m.restarts(), 0);
}

}  // namespace unibody::momentum_test
