#include "core/exact_sum.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>

namespace unibody::exact_sum_test {
namespace {

__extension__ using Wide = __int128;

double exact(const std::vector<double>& values) {
  ExactSum sum;
  for (double x : values) sum += x;
  return sum.value();
}

TEST(ExactSum, EmptyIsZero) {
  EXPECT_EQ(ExactSum{}.value(), 0.0);
  EXPECT_FALSE(std::signbit(exact({-0.0, -0.0})));
}

TEST(ExactSum, OneNumberComesBack) {
  std::mt19937_64 random(1);
  for (int k = 0; k < 100000; ++k) {
    const auto x = std::bit_cast<double>(random());
    if (!std::isfinite(x)) continue;
    ASSERT_EQ(exact({x}), x);
  }
  for (double x :
       {0.0, 5e-324, -5e-324, 2.2250738585072011e-308, 2.2250738585072014e-308, 1.7976931348623157e308, -1.7976931348623157e308})
    EXPECT_EQ(exact({x}), x);
}

TEST(ExactSum, Cancellation) {
  EXPECT_EQ(exact({1e308, 1.0, -1e308}), 1.0);
  EXPECT_EQ(exact({1e308, 1e308, 5e-324, -1e308, -1e308}), 5e-324);  // passes through overflow
  EXPECT_EQ(exact({1.0, 1e-300, -1.0}), 1e-300);
  EXPECT_EQ(exact({-1.0, 1e-300, 1.0, -2e-300}), -1e-300);
}

TEST(ExactSum, RoundsOnceToNearestEven) {
  const double half = std::ldexp(1.0, -53);
  EXPECT_EQ(exact({1.0, half}), 1.0);
  EXPECT_EQ(exact({1.0, half, 5e-324}), 1.0 + 2 * half);
  EXPECT_EQ(exact({1.0 + 2 * half, half}), 1.0 + 4 * half);
  EXPECT_EQ(exact({-1.0, -half, -5e-324}), -1.0 - 2 * half);
  EXPECT_EQ(exact({1.0, half, -5e-324}), 1.0);
  EXPECT_EQ(exact({1.7976931348623157e308, 1e292}), std::numeric_limits<double>::infinity());
}

TEST(ExactSum, IntegersAgreeWithIntegerArithmetic) {
  std::mt19937_64 random(2);
  for (int trial = 0; trial < 200; ++trial) {
    Wide expected = 0;
    ExactSum sum;
    for (int k = 0; k < 100; ++k) {
      const auto x = static_cast<std::int64_t>(random()) >> (random() % 60 + 4);
      const auto scale = static_cast<int>(random() % 40);
      expected += static_cast<Wide>(x) << scale;
      sum += std::ldexp(static_cast<double>(x >> 8), scale + 8);
      sum += std::ldexp(static_cast<double>(x & 255), scale);
    }
    ASSERT_EQ(sum.value(), static_cast<double>(expected));
  }
}

TEST(ExactSum, AgreesWithLongDoubleWhereThatIsExact) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> uniform(1, 2);
  long double expected = 0;
  ExactSum sum;
  for (int k = 0; k < 1000; ++k) {  // 10 bits of carries fit into the 64-bit mantissa
    const double x = uniform(random);
    expected += x, sum += x;
  }
  EXPECT_EQ(sum.value(), static_cast<double>(expected));
}

TEST(ExactSum, OrderAndGroupingDoNotMatter) {
  std::mt19937_64 random(4);
  std::vector<double> values;
  for (int k = 0; k < 2000; ++k) {
    const auto x = std::bit_cast<double>(random());
    if (std::isfinite(x)) values.push_back(std::ldexp(x, -20));
  }
  const double expected = exact(values);
  for (int trial = 0; trial < 20; ++trial) {
    std::shuffle(values.begin(), values.end(), random);
    EXPECT_EQ(exact(values), expected);
    ExactSum left, right;
    for (std::size_t k = 0; k < values.size(); ++k) (random() % 3 != 0 ? left : right) += values[k];
    left += right;
    EXPECT_EQ(left.value(), expected);
  }
}

TEST(ExactSum, SpecialsAreFlagged) {
  const double inf = std::numeric_limits<double>::infinity(), nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(exact({1, inf}), inf);
  EXPECT_EQ(exact({1, -inf}), -inf);
  EXPECT_TRUE(std::isnan(exact({inf, -inf})));
  EXPECT_TRUE(std::isnan(exact({nan, 1})));
  ExactSum sum;
  sum += 1.0;
  EXPECT_TRUE(sum.finite());
  sum += nan;
  EXPECT_FALSE(sum.finite());
}

TEST(RanksExactSum, SameOnAnyNumberOfRanks) {
  int rank = 0, ranks = 1;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank), MPI_Comm_size(MPI_COMM_WORLD, &ranks);
  std::mt19937_64 random(5);
  ExactSum whole, mine;
  std::vector<ExactSum> several(3);
  for (int k = 0; k < 5000; ++k) {
    const double x = std::ldexp(std::bit_cast<double>(random() | 1), -600);
    if (!std::isfinite(x)) continue;
    whole += x;
    if (k % ranks == rank) mine += x, several[static_cast<std::size_t>(k % 2)] += x;
  }
  EXPECT_EQ(all_sums(MPI_COMM_WORLD, {&mine, 1})[0], whole.value());
  const auto values = all_sums(MPI_COMM_WORLD, several);
  ASSERT_EQ(values.size(), 3u);
  EXPECT_EQ(values[2], 0.0);
}

}  // namespace
}  // namespace unibody::exact_sum_test
