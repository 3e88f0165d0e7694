// A formula of the time t (s), as a scene gives it in text: "0.2 * sin(2 * pi * t) * (t > 1)". muParser reads it.
#pragma once

#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

namespace unibody {

// A formula that is no number at some time, or one out of its bounds.
struct ExpressionFault : std::runtime_error {
  ExpressionFault(const std::string& found_then, const std::string& expected)
      : std::runtime_error(found_then + ", expected " + expected), found(found_then) {}
  std::string found;  // the formula, its value and the time
};

class Expression {
 public:
  // Values are multiplied by `factor`; before that they must be in [low, high]. Throws std::invalid_argument, in words, where the
  // text is no formula of t.
  Expression(const std::string& text, double factor = 1, double low = -1e308, double high = 1e308);
  ~Expression();

  // Throws ExpressionFault where the value is not finite or out of bounds.
  double at(double time) const;

  // Over (from, to), from < to, by Gauss' rule with five points in pieces of at most `piece` s: exact for polynomials of t up to
  // the ninth power, and off by some share of a piece where the formula jumps.
  double mean(double from, double to) const;
  static constexpr double piece = 1.0 / 128;

  const std::string& text() const { return text_; }
  double factor() const { return factor_; }

 private:
  struct Formula;

  double integral(double from, double to) const;
  double integral_from_zero(std::size_t pieces) const;

  std::string text_;
  double factor_, low_, high_;
  std::unique_ptr<Formula> formula_;
  mutable std::vector<double> sums_;  // integrals from 0 to multiples of a piece: those of inlets begin long ago
};

}  // namespace unibody
