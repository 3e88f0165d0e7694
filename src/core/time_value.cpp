#include "core/time_value.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>

namespace unibody {

TimeValue TimeValue::table(std::vector<std::array<double, 2>> points, Between between, bool periodic) {
  TimeValue value;
  value.points_ = std::move(points), value.between_ = between, value.periodic_ = periodic;
  return value;
}

TimeValue TimeValue::sine(double mean, double amplitude, double frequency, double phase) {
  TimeValue value(mean);
  value.amplitude_ = amplitude, value.frequency_ = frequency, value.phase_ = phase;
  return value;
}

TimeValue TimeValue::expression(std::shared_ptr<const Expression> formula, double largest) {
  TimeValue value;
  value.expression_ = std::move(formula), value.amplitude_ = largest;
  return value;
}

TimeValue TimeValue::later(double by) const {
  TimeValue value = *this;
  for (auto& point : value.points_) point[0] += by;
  value.phase_ += expression_ ? by : -2 * M_PI * frequency_ * by;
  return value;
}

std::size_t TimeValue::piece_at(double time) const {
  const auto after = std::upper_bound(points_.begin(), points_.end(), time, [](double t, const auto& p) { return t < p[0]; });
  return after == points_.begin() ? 0 : static_cast<std::size_t>(after - points_.begin()) - 1;
}

double TimeValue::within(std::size_t piece, double time) const {
  const auto& [start, value] = points_[piece];
  if (piece + 1 == points_.size() || time <= start || between_ == Between::steps) return value;
  const auto& [end, next] = points_[piece + 1];
  const double s = (time - start) / (end - start);
  return value + (next - value) * (between_ == Between::linear ? s : s * s * (3 - 2 * s));
}

double TimeValue::largest() const {
  double most = std::abs(mean_) + std::abs(amplitude_);
  for (const auto& [time, value] : points_) most = std::max(most, std::abs(value));  // no law leaves what its points span
  return most;
}

double TimeValue::at(double time) const {
  if (expression_) return expression_->at(time - phase_);
  if (points_.empty()) return mean_ + (amplitude_ == 0 ? 0 : amplitude_ * std::sin(2 * M_PI * frequency_ * time + phase_));
  if (periodic_) time -= period() * std::floor((time - first()) / period());
  return within(piece_at(time), time);
}

double TimeValue::integral_of(std::size_t piece, double from, double to) const {
  const auto& [start, value] = points_[piece];
  if (piece + 1 == points_.size() || to <= start || between_ == Between::steps) return (to - from) * value;
  const auto& [end, next] = points_[piece + 1];
  if (value == next) return (to - from) * value;
  const double length = end - start, a = (from - start) / length, b = (to - start) / length;
  if (between_ == Between::linear) return (to - from) * (value + (next - value) * 0.5 * (a + b));
  // The difference of s^3 - s^4 / 2, with its factor b - a taken out.
  const double squares = a * a + a * b + b * b, cubes = (a + b) * (a * a + b * b);
  return (to - from) * (value + (next - value) * (squares - 0.5 * cubes));
}

double TimeValue::integral(double from, double to) const {
  double sum = 0;
  if (from < first()) {
    const double end = std::min(to, first());
    sum = (end - from) * points_.front()[1], from = end;
  }
  for (std::size_t piece = piece_at(from); from < to; ++piece) {
    const double end = piece + 1 < points_.size() ? std::min(to, points_[piece + 1][0]) : to;
    sum += integral_of(piece, from, end), from = end;
  }
  return sum;
}

double TimeValue::mean(double from, double to) const {
  if (expression_) return expression_->mean(from - phase_, to - phase_);
  if (points_.empty()) {
    if (amplitude_ == 0) return mean_;
    const double half = M_PI * frequency_ * (to - from);
    return mean_ + amplitude_ * std::sin(M_PI * frequency_ * (from + to) + phase_) * (half == 0 ? 1 : std::sin(half) / half);
  }
  if (!periodic_) return integral(from, to) / (to - from);
  const double whole = std::floor((from - first()) / period()), end = points_.back()[0];
  double sum = 0, a = from - whole * period(), left = to - from;
  const double rounds = std::floor(left / period());
  if (rounds > 0) sum = rounds * integral(first(), end), left -= rounds * period();
  while (left > 0) {
    if (a >= end) a = first();
    const double b = std::min(a + left, end);
    if (b == a) break;  // no more than round-off is left
    sum += integral(a, b), left -= b - a, a = b;
  }
  return sum / (to - from);
}

std::string TimeValue::text() const {
  std::ostringstream text;
  text.precision(17);
  if (expression_) {
    text << "expression " << expression_->text() << " times " << expression_->factor() << " from " << phase_;
    return text.str();
  }
  if (points_.empty()) {
    text << mean_;
    if (amplitude_ != 0) text << " sine " << amplitude_ << ' ' << frequency_ << ' ' << phase_;
    return text.str();
  }
  text << "table " << static_cast<int>(between_) << ' ' << periodic_;
  for (const auto& [time, value] : points_) text << ' ' << time << ' ' << value;
  return text.str();
}

}  // namespace unibody
