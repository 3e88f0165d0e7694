// Formulas of the time against closed forms.
#include "core/expression.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

#include "core/time_value.hpp"

namespace unibody::expression_test {

namespace {

std::string fault_of(const std::string& text) {
  try {
    Expression expression(text);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

}  // namespace

TEST(Expression, HasValues) {
  EXPECT_DOUBLE_EQ(Expression("2 * sin(3 * t) + 1").at(0.7), 2 * std::sin(2.1) + 1);
  EXPECT_DOUBLE_EQ(Expression("t > 1 ? pi : e").at(2), M_PI);
  EXPECT_DOUBLE_EQ(Expression("t > 1 ? pi : e").at(0.5), M_E);
  EXPECT_DOUBLE_EQ(Expression("floor(t) + mod(t, 0.4)").at(1.5), 1.3);
  EXPECT_DOUBLE_EQ(Expression("mod(t, 2)").at(-0.5), 1.5);
  EXPECT_DOUBLE_EQ(Expression("ln(t) + log10(t) + t^2").at(10), std::log(10.0) + 1 + 100);
  EXPECT_DOUBLE_EQ(Expression("90", M_PI / 180).at(0), M_PI / 2);
}

// Every function that the page on scenes lists.
TEST(Expression, KnowsTheseFunctions) {
  for (const char* name : {"sin", "cos", "tan", "asin", "acos", "atan", "sinh", "cosh", "tanh", "exp", "ln", "log2", "log10",
                           "sqrt", "abs", "sign", "rint", "floor"})
    EXPECT_TRUE(std::isfinite(Expression(std::string(name) + "(t)").at(0.5))) << name;
  for (const char* name : {"atan2", "mod", "min", "max", "sum", "avg"})
    EXPECT_TRUE(std::isfinite(Expression(std::string(name) + "(t, 2)").at(0.5))) << name;
}

TEST(Expression, RefusesWhatIsNoFormula) {
  for (const char* text : {"", "2 *", "x + 1", "sin(t", "1, 2", "t = 2", "sin(1, 2)", "hallo(t)"})
    EXPECT_NE(fault_of(text), "") << text;
  for (const char* text : {"t + 1", "t >= 1", "t == 1", "t != 1", "t <= 1"}) EXPECT_EQ(fault_of(text), "") << text;
}

TEST(Expression, ValuesOutOfBoundsAreTold) {
  const auto fault_at = [](const Expression& e, double t) {
    try {
      e.at(t);
    } catch (const std::runtime_error& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_EQ(fault_at(Expression("1 - t", 1, 0), 0.5), "");
  EXPECT_EQ(fault_at(Expression("1 - t", 1, 0), 2), "'1 - t' = -1 at t = 2 s, expected a number >= 0");
  EXPECT_EQ(fault_at(Expression("t", 1, 0, 1), 2), "'t' = 2 at t = 2 s, expected a number >= 0 and <= 1");
  EXPECT_EQ(fault_at(Expression("1 / t"), 0), "'1 / t' = inf at t = 0 s, expected a finite number");
}

// Means in closed form: of powers exact, of waves to the digits that the page tells, over steps as over long times.
TEST(Expression, Means) {
  const Expression ninth("10 * t^9");
  EXPECT_NEAR(ninth.mean(0.2, 0.216) * 0.016, std::pow(0.216, 10) - std::pow(0.2, 10), 1e-19);
  EXPECT_NEAR(ninth.mean(0, 3) * 3, std::pow(3, 10), 1e-10 * std::pow(3, 10));
  for (const double f : {1.0, 60.0}) {
    const Expression wave("sin(2 * pi * " + std::to_string(f) + " * t)");
    for (const auto& [from, to] : {std::pair{0.1, 0.116}, {0.1, 0.101}, {0.3, 0.41}, {0.3, 7.3}, {-0.2, 0.1}}) {
      const double w = 2 * M_PI * f, exact = (std::cos(w * from) - std::cos(w * to)) / w / (to - from);
      EXPECT_NEAR(wave.mean(from, to), exact, 1e-6) << f << ' ' << from;
    }
  }
  EXPECT_NEAR(Expression("t > 1").mean(0, 100), 0.99, 1.0 / 128 / 100);
}

TEST(Expression, AsAValueInTime) {
  const TimeValue value = TimeValue::expression(std::make_shared<const Expression>("3 * t"), 6);
  EXPECT_TRUE(value.changes());
  EXPECT_EQ(value.at(2), 6);
  EXPECT_EQ(value.largest(), 6);
  EXPECT_NEAR(value.mean(1, 2), 4.5, 1e-14);
  EXPECT_EQ(value.later(0.5).at(2), 4.5);
  EXPECT_NEAR(value.later(0.5).mean(1, 2), 3, 1e-14);
  EXPECT_EQ(value.later(0.5).later(0.5).at(2), 3);
  EXPECT_NE(value.text(), value.later(0.5).text());
  EXPECT_NE(value.text(), TimeValue::expression(std::make_shared<const Expression>("3 * t + 0"), 6).text());
}

}  // namespace unibody::expression_test
