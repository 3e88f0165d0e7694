// A number that changes in time by a law that is known beforehand: constant, a table, a sine, or a formula.
//
// It is a pure function of time, so that it is the same on any number of ranks and through a restart.
#pragma once

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "core/expression.hpp"
#include "core/types.hpp"

namespace unibody {

class TimeValue {
 public:
  // What holds between two points of a table: the straight line; the first of them; 3 s^2 - 2 s^3, which has no slope at either.
  enum class Between { linear, steps, smooth };

  TimeValue(double constant = 0) : mean_(constant) {}

  // A table of points (time in s, value), one or more, whose times ascend. Before the first point the value of the first holds,
  // and after the last point that of the last. A periodic table has two points or more, and repeats from the first to the last.
  static TimeValue table(std::vector<std::array<double, 2>> points, Between between, bool periodic);

  // mean + amplitude sin(2 pi frequency t + phase); Hz, rad
  static TimeValue sine(double mean, double amplitude, double frequency, double phase);

  // A formula, whose values are in [-largest, largest] while the scene runs.
  static TimeValue expression(std::shared_ptr<const Expression> formula, double largest);

  // The same law that starts `by` s later.
  TimeValue later(double by) const;

  bool changes() const { return !points_.empty() || amplitude_ != 0 || expression_; }
  double at(double time) const;
  // Over (from, to), from < to: the integral over the length, exact but for round-off.
  double mean(double from, double to) const;
  double largest() const;    // a bound of the value's size at all times
  std::string text() const;  // equal for equal laws, and for no others

 private:
  double integral(double from, double to) const;  // of a table, from its first time on
  double within(std::size_t piece, double time) const;
  double integral_of(std::size_t piece, double from, double to) const;
  std::size_t piece_at(double time) const;  // the last point that is not after it; the first for all before
  double first() const { return points_.front()[0]; }
  double period() const { return points_.back()[0] - first(); }

  double mean_ = 0, amplitude_ = 0, frequency_ = 0, phase_ = 0;
  std::shared_ptr<const Expression>
      expression_;  // then the amplitude is its largest value, and the phase by what it starts later
  std::vector<std::array<double, 2>> points_;
  Between between_ = Between::linear;
  bool periodic_ = false;
};

struct TimeVector : std::array<TimeValue, 3> {
  bool changes() const { return (*this)[0].changes() || (*this)[1].changes() || (*this)[2].changes(); }
  Vec3 at(double time) const { return {(*this)[0].at(time), (*this)[1].at(time), (*this)[2].at(time)}; }
  Vec3 mean(double from, double to) const {
    return {(*this)[0].mean(from, to), (*this)[1].mean(from, to), (*this)[2].mean(from, to)};
  }
  double largest() const { return Vec3((*this)[0].largest(), (*this)[1].largest(), (*this)[2].largest()).norm(); }
  std::string text() const { return (*this)[0].text() + ", " + (*this)[1].text() + ", " + (*this)[2].text(); }
};

}  // namespace unibody
