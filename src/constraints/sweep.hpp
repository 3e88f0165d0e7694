// One sweep of the Jacobi solvers: how a multiplier is updated, and the sums that a sweep tells its solver.
//
// The update stands here once, for a single number and for four at a time (Number: double or Vec4d). Of a row, `r` is the
// residual (m/s), `next` the multiplier that the step leads to, `step` = next - y with y the multiplier that the sweep started
// from, and `taken` = P step is how much of the residual the step takes away (m/s), P being the bound of the row's own block.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "core/simd.hpp"

namespace unibody {

// Where the next Jacobi sweep starts: new + momentum (new - old multiplier) + overshoot (new - where this sweep started).
struct Extrapolation {
  double momentum = 0, overshoot = 0;
};

// What one sweep tells the solver. Maxima and fixed-point sums: the same whatever the order or the number of ranks.
struct SweepSums {
  std::int64_t gradient = 0;  // sum r . (new - old multiplier), the gradient restart test, in units of `unit`
  std::int64_t progress = 0;  // sum P |new - y|^2, the residual restart test, in units of `unit`
  double largest = 0;         // largest single term of the two sums (J): sets the unit of the sweeps that follow
  double change = 0;          // largest P |new - y| (m): the sweep's own residual, for the stop test
  double unit = 1;            // J
};

// Rounds a term to a whole number of units, clamped so that 2^22 terms cannot overflow.
inline std::int64_t whole_units(double term, double per_unit) {
  const double scaled = std::min(std::max(term * per_unit, -1.0e12), 1.0e12);
  return static_cast<std::int64_t>(std::llrint(scaled));
}

// Four terms at once, with the same bits: adding 1.5 * 2^52 leaves the rounded number in the low half of the word.
inline Mask4 whole_units(Vec4d terms, double per_unit) {
  constexpr double shift = 6755399441055744.0;
  const Vec4d scaled = min(max(terms * broadcast(per_unit), broadcast(-1.0e12)), broadcast(1.0e12));
  return reinterpret_cast<Mask4>(scaled + broadcast(shift)) - reinterpret_cast<Mask4>(broadcast(shift));
}

// The terms of one constraint in a sweep's sums, and the largest change so far.
template <class Number>
struct SweepTerms {
  Number gradient{}, progress{}, change{};
};

// The factors of an Extrapolation, as the rows of a sweep need them.
template <class Number>
struct Update {
  Number momentum, overshoot;

  // Updates a row's multiplier and its extrapolation y; returns the change of y, which is what the bodies feel.
  [[gnu::always_inline]] inline Number advance(Number& lambda, Number& y, Number next, Number step, Number r, Number power,
                                               Number change, SweepTerms<Number>& terms) const {
    const Number forward = next - lambda, new_y = next + momentum * forward + overshoot * step;
    terms.gradient += r * forward;
    terms.progress += power;
    terms.change = larger(terms.change, change);
    const Number moved = new_y - y;
    lambda = next, y = new_y;
    return moved;
  }

 private:
  static double larger(double a, double b) { return std::max(a, b); }
  static Vec4d larger(Vec4d a, Vec4d b) { return max(a, b); }
};

inline Update<double> update_of(const Extrapolation& e) { return {e.momentum, e.overshoot}; }
inline Update<Vec4d> update_of_four(const Extrapolation& e) { return {broadcast(e.momentum), broadcast(e.overshoot)}; }

// Adds one constraint's terms to a sweep's sums. counted: this rank counts the constraint in sums over all ranks.
inline void add_terms(SweepSums& sums, const SweepTerms<double>& terms, bool counted) {
  const double per_unit = 1 / sums.unit;
  sums.largest = std::max(sums.largest, std::max(std::abs(terms.gradient), terms.progress));
  sums.change = std::max(sums.change, terms.change);
  if (!counted) return;
  sums.gradient += whole_units(terms.gradient, per_unit), sums.progress += whole_units(terms.progress, per_unit);
}

// The same of a sweep over blocks of four constraints, block after block.
class SweepTotals {
 public:
  explicit SweepTotals(double unit) : per_unit_(1 / unit) {}

  // The terms of the next block: they carry the largest change on.
  [[gnu::always_inline]] inline SweepTerms<Vec4d> start() const { return {broadcast(0), broadcast(0), change_}; }

  // Adds a block's terms. counted: a mask of the lanes that this rank counts.
  [[gnu::always_inline]] inline void close(const SweepTerms<Vec4d>& terms, Mask4 counted) {
    largest_ = max(largest_, max(abs(terms.gradient), terms.progress));
    gradient_ += whole_units(terms.gradient, per_unit_) & counted, progress_ += whole_units(terms.progress, per_unit_) & counted;
    change_ = terms.change;
  }

  // The same where this rank counts all lanes.
  [[gnu::always_inline]] inline void close(const SweepTerms<Vec4d>& terms) {
    largest_ = max(largest_, max(abs(terms.gradient), terms.progress));
    gradient_ += whole_units(terms.gradient, per_unit_), progress_ += whole_units(terms.progress, per_unit_);
    change_ = terms.change;
  }

  // step: s, by which changes of velocities become lengths.
  void add_to(SweepSums& sums, double step) const {
    for (std::size_t l = 0; l < lanes; ++l) sums.gradient += gradient_[l], sums.progress += progress_[l];
    sums.change = std::max(sums.change, step * horizontal_max(change_));
    sums.largest = std::max(sums.largest, horizontal_max(largest_));
  }

 private:
  double per_unit_;
  Vec4d change_ = broadcast(0), largest_ = broadcast(0);
  Mask4 gradient_{}, progress_{};
};

}  // namespace unibody
