#include "core/expression.hpp"

#include <muParser.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <sstream>

namespace unibody {

namespace {
constexpr std::size_t npos = std::string::npos;
}

struct Expression::Formula {
  mu::Parser parser;
  double t = 0;
};

Expression::Expression(const std::string& text, double factor, double low, double high)
    : text_(text), factor_(factor), low_(low), high_(high), formula_(std::make_unique<Formula>()) {
  for (std::size_t k = 0; k < text.size(); ++k)  // muParser would assign to t
    if (text[k] == '=' && (k + 1 == text.size() || text[k + 1] != '=') &&
        (k == 0 || std::string("=<>!").find(text[k - 1]) == npos))
      throw std::invalid_argument("= does not compare, == does");
  mu::Parser& parser = formula_->parser;
  try {
    parser.ClearConst();
    parser.DefineConst("pi", M_PI), parser.DefineConst("e", M_E);
    parser.DefineVar("t", &formula_->t);
    parser.DefineFun("floor", [](double x) { return std::floor(x); });
    parser.DefineFun("mod", [](double x, double y) { return x - y * std::floor(x / y); });
    parser.SetExpr(text);
    parser.Eval();
    if (parser.GetNumResults() != 1) throw std::invalid_argument("one formula, not a list of some");
  } catch (const mu::Parser::exception_type& error) {
    throw std::invalid_argument(error.GetMsg());
  }
}

Expression::~Expression() = default;

double Expression::at(double time) const {
  formula_->t = time;
  const double value = formula_->parser.Eval();
  if (std::isfinite(value) && value >= low_ && value <= high_) return factor_ * value;
  std::ostringstream found, expected;
  found.precision(12);
  found << "'" << text_ << "' = ";
  std::isnan(value) ? found << "no number" : found << value;
  found << " at t = " << time << " s";
  if (low_ > -1e308) expected << "a number >= " << low_;
  if (high_ < 1e308) expected << (low_ > -1e308 ? " and <= " : "a number <= ") << high_;
  throw ExpressionFault(found.str(), expected.str().empty() ? "a finite number" : expected.str());
}

double Expression::integral(double from, double to) const {
  static constexpr std::array<double, 5> places{-0.9061798459386640, -0.5384693101056831, 0, 0.5384693101056831,
                                                0.9061798459386640};
  static constexpr std::array<double, 5> weights{0.2369268850561891, 0.4786286704993665, 0.5688888888888889, 0.4786286704993665,
                                                 0.2369268850561891};
  const auto pieces = static_cast<std::size_t>(std::max(1.0, std::ceil((to - from) / piece * (1 - 1e-12))));
  const double half = 0.5 * (to - from) / static_cast<double>(pieces);
  double sum = 0;
  for (std::size_t k = 0; k < pieces; ++k) {
    const double middle = from + half * static_cast<double>(2 * k + 1);
    for (std::size_t i = 0; i < places.size(); ++i) sum += half * weights[i] * at(middle + half * places[i]);
  }
  return sum;
}

double Expression::integral_from_zero(std::size_t pieces) const {
  if (sums_.empty()) sums_.push_back(0);
  while (sums_.size() <= pieces) {
    const auto k = static_cast<double>(sums_.size());
    sums_.push_back(sums_.back() + integral((k - 1) * piece, k * piece));
  }
  return sums_[pieces];
}

double Expression::mean(double from, double to) const {
  constexpr double few = 64;  // pieces: more are not summed anew each time
  if (from < 0 || to - from <= few * piece) return integral(from, to) / (to - from);
  const double first = std::ceil(from / piece), last = std::floor(to / piece);
  double sum = integral_from_zero(static_cast<std::size_t>(last)) - integral_from_zero(static_cast<std::size_t>(first));
  if (first * piece > from) sum += integral(from, first * piece);
  if (to > last * piece) sum += integral(last * piece, to);
  return sum / (to - from);
}

}  // namespace unibody
