#include "solve/momentum.hpp"

#include <gtest/gtest.h>

namespace unibody {

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
  Momentum m;
  EXPECT_EQ(m.next({}, false), 0);
  EXPECT_NEAR(m.next(sums(-1, 100), true), 0.28175, 1e-5);
  EXPECT_NEAR(m.next(sums(-1, 90), true), 0.43404, 5e-6);
  EXPECT_EQ(m.restarts(), 0);
}

// theta_{k+1}^2 = (1 - theta_{k+1}) theta_k^2 is what the formula solves; beta then tends to 1 - 3/k.
TEST(Momentum, SolvesNesterovsRecursion) {
  Momentum m;
  double theta = 1;
  for (int k = 0; k < 1000; ++k) {
    const double beta = m.next({}, false);
    double low = 0, high = 1;
    for (int i = 0; i < 100; ++i) {
      const double x = 0.5 * (low + high);
      (x * x < (1 - x) * theta * theta ? low : high) = x;
    }
    EXPECT_NEAR(beta, theta * (1 - theta) / (theta * theta + low), 1e-12);
    theta = low;
  }
  EXPECT_NEAR(m.next({}, false), 1 - 3.0 / 1001, 1e-4);
}

TEST(Momentum, RestartsUphill) {
  Momentum m;
  for (int k = 0; k < 5; ++k) m.next(sums(-1, 10), true);
  EXPECT_EQ(m.next(sums(1, 10), true), 0);
  EXPECT_EQ(m.restarts(), 1);
  EXPECT_EQ(m.next(sums(-1, 10), true), 0);  // theta is 1 again
  EXPECT_NEAR(m.next(sums(-1, 10), true), 0.28175, 1e-5);
}

TEST(Momentum, RestartsWhereTheStepIsTwiceTheSmallest) {
  Momentum m;
  for (int k = 0; k < 5; ++k) m.next(sums(-1, 100 - k), true);
  EXPECT_GT(m.next(sums(-1, 4 * 96), true), 0);  // not more than twice in length
  EXPECT_EQ(m.next(sums(-1, 4 * 96 + 1), true), 0);
  EXPECT_EQ(m.next(sums(-1, 4 * 96 + 1), true), 0);  // theta is 1; the bar has been raised, so this is no restart
  EXPECT_EQ(m.restarts(), 1);
}

TEST(Momentum, IgnoresSumsThatAreNotValid) {
  Momentum m;
  m.next(sums(1, 1), false);
  EXPECT_GT(m.next(sums(1, 1 << 20), false), 0);
  EXPECT_EQ(m.restarts(), 0);
}

}  // namespace unibody
