// Values in time against closed forms and sums of many samples.
#include "core/time_value.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace unibody::time_value_test {
namespace {

using Between = TimeValue::Between;

// The midpoint rule with n samples; of pieces with jumps it is off by a sample at each.
double sampled_mean(const TimeValue& value, double from, double to, int n) {
  double sum = 0;
  for (int i = 0; i < n; ++i) sum += value.at(from + (i + 0.5) * (to - from) / n);
  return sum / n;
}

TEST(TimeValue, AConstantDoesNotChange) {
  const TimeValue value = 0.3;
  EXPECT_FALSE(value.changes());
  EXPECT_EQ(value.at(7), 0.3);
  EXPECT_EQ(value.mean(1, 7), 0.3);
}

TEST(TimeValue, ATableHoldsItsPointsAndWhatIsBetween) {
  const std::vector<std::array<double, 2>> points{{1, 2}, {3, 6}, {4, -2}};
  for (const Between between : {Between::linear, Between::steps, Between::smooth}) {
    const TimeValue value = TimeValue::table(points, between, false);
    EXPECT_TRUE(value.changes());
    for (const auto& [time, y] : points) EXPECT_EQ(value.at(time), y);
    EXPECT_EQ(value.at(-5), 2);
    EXPECT_EQ(value.at(9), -2);
  }
  EXPECT_DOUBLE_EQ(TimeValue::table(points, Between::linear, false).at(1.5), 3);
  EXPECT_DOUBLE_EQ(TimeValue::table(points, Between::steps, false).at(2.9), 2);
  EXPECT_DOUBLE_EQ(TimeValue::table(points, Between::smooth, false).at(1.5), 2 + 4 * (3 * 0.0625 - 2 * 0.015625));
  EXPECT_DOUBLE_EQ(TimeValue::table(points, Between::linear, true).at(1.5 + 3 * 11), 3);  // it repeats after 3 s
  EXPECT_DOUBLE_EQ(TimeValue::table(points, Between::linear, true).at(1.5 - 3 * 11), 3);
}

TEST(TimeValue, MeansOfATableInClosedForm) {
  const std::vector<std::array<double, 2>> points{{0, 0}, {2, 4}};
  EXPECT_DOUBLE_EQ(TimeValue::table(points, Between::linear, false).mean(0, 2), 2);
  EXPECT_DOUBLE_EQ(TimeValue::table(points, Between::linear, false).mean(0, 1), 1);
  EXPECT_DOUBLE_EQ(TimeValue::table(points, Between::linear, false).mean(-1, 3), (0 + 4 + 4) / 4.0);
  EXPECT_DOUBLE_EQ(TimeValue::table(points, Between::steps, false).mean(1, 4), (0 + 8) / 3.0);
  EXPECT_DOUBLE_EQ(TimeValue::table(points, Between::smooth, false).mean(0, 2), 2);
  EXPECT_DOUBLE_EQ(TimeValue::table(points, Between::smooth, false).mean(0, 1), 4 * (0.125 - 0.03125) / 0.5);
  EXPECT_DOUBLE_EQ(TimeValue::table(points, Between::linear, true).mean(0, 200), 2);
}

TEST(TimeValue, MeansAreThoseOfManySamples) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> any(-1, 1);
  for (int trial = 0; trial < 60; ++trial) {
    std::vector<std::array<double, 2>> points{{any(random), any(random)}};
    for (int k = 0; k < 4; ++k) points.push_back({points.back()[0] + 0.1 + std::abs(any(random)), any(random)});
    const auto between = static_cast<Between>(trial % 3);
    const bool periodic = trial % 2 == 0;
    if (periodic) points.back()[1] = points.front()[1];  // no jump where it begins anew
    const TimeValue value = TimeValue::table(points, between, periodic);
    const double from = 8 * any(random), to = from + 0.01 + 3 * std::abs(any(random));
    EXPECT_NEAR(value.mean(from, to), sampled_mean(value, from, to, 100'000), between == Between::steps ? 3e-4 : 1e-8) << trial;
  }
}

// Means of the parts, by their lengths, make that of the whole: nothing is lost or counted twice where pieces and periods end.
TEST(TimeValue, PartsAddUpToTheWhole) {
  const std::vector<std::array<double, 2>> points{{0, 0}, {0.1, 1}, {0.3, -2}, {0.7, 0}};
  for (const Between between : {Between::linear, Between::steps, Between::smooth})
    for (const bool periodic : {false, true}) {
      const TimeValue value = TimeValue::table(points, between, periodic);
      double sum = 0;
      for (int k = 0; k < 1000; ++k) sum += 0.01 * value.mean(0.01 * k, 0.01 * (k + 1));
      EXPECT_NEAR(sum, 10 * value.mean(0, 10), 1e-12);
    }
}

TEST(TimeValue, ASineAndItsMean) {
  const double f = 3, phase = 0.4;
  const TimeValue value = TimeValue::sine(0.5, 2, f, phase);
  EXPECT_DOUBLE_EQ(value.at(0.2), 0.5 + 2 * std::sin(2 * M_PI * f * 0.2 + phase));
  for (const double length : {1e-9, 1e-3, 0.1, 4.7}) {
    const double w = 2 * M_PI * f, a = 0.3, b = a + length;
    const double exact =
        length < 1e-6 ? value.at(a + length / 2) : 0.5 + 2 * (std::cos(w * a + phase) - std::cos(w * b + phase)) / (w * length);
    EXPECT_NEAR(value.mean(a, b), exact, 1e-12) << length;
  }
}

TEST(TimeValue, NoValueIsAboveTheLargest) {
  const TimeValue laws[] = {-3, TimeValue::sine(-1, 2, 3, 0.4),
                            TimeValue::table({{0, 1}, {1, -7}, {2, 3}}, TimeValue::Between::smooth, true)};
  const double expected[] = {3, 3, 7};
  for (std::size_t k = 0; k < 3; ++k) {
    double most = 0;
    for (int i = 0; i < 4000; ++i) most = std::max(most, std::abs(laws[k].at(-2 + 0.001 * i)));
    EXPECT_NEAR(most, expected[k], 1e-4);
    EXPECT_GE(laws[k].largest(), most);
    EXPECT_NEAR(laws[k].largest(), expected[k], 1e-14);
  }
}

TEST(TimeValue, ItsTextTellsLawsApart) {
  const std::vector<std::array<double, 2>> points{{0, 0}, {2, 4}}, others{{0, 0}, {2, 4.0000000000000009}};
  const std::string text = TimeValue::table(points, Between::linear, false).text();
  EXPECT_EQ(text, TimeValue::table(points, Between::linear, false).text());
  EXPECT_NE(text, TimeValue::table(points, Between::smooth, false).text());
  EXPECT_NE(text, TimeValue::table(points, Between::linear, true).text());
  EXPECT_NE(text, TimeValue::table(others, Between::linear, false).text());
  EXPECT_NE(TimeValue::sine(0, 1, 2, 0).text(), TimeValue::sine(0, 1, 2, 0.1).text());
}

}  // namespace
}  // namespace unibody::time_value_test
