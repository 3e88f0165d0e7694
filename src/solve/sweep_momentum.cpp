#include "solve/sweep_momentum.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "solve/sum_reduction.hpp"

namespace unibody {

namespace {

// kg m^2, what resists turning: exact where the inertia is the same about all axes, else a mean, which the restart tests take.
double inertia_of(const SolveState& state, std::size_t i) {
  if (state.isotropic[i]) return state.bodies[i].inverse_inertia > 0 ? 1 / state.bodies[i].inverse_inertia : 0;
  const InverseInertia& w = state.inertia[i];
  const double trace = w.xx + w.yy + w.zz;
  return trace > 0 ? 3 / trace : 0;
}

}  // namespace

SweepMomentum::SweepMomentum(System& system)
    : system_(system),
      before_(system.bodies.get_allocator()),
      start_(system.bodies.get_allocator()),
      unknowns_(system.bodies.get_allocator()) {
  before_.resize(system.first_static), start_.resize(system.first_static);
  for (std::size_t i = 0; i < system.first_static; ++i) before_[i] = start_[i] = motion_of(system.bodies[i]);
  std::size_t count = 0;
  for_each_acting(system, [&](auto, auto& batch) { batch.for_each_unknown([&](std::span<double> x) { count += x.size(); }); });
  unknowns_.reserve(count);
  for_each_acting(system, [&](auto, auto& batch) {
    batch.for_each_unknown([&](std::span<double> x) { unknowns_.insert(unknowns_.end(), x.begin(), x.end()); });
  });
}

void SweepMomentum::measure(SweepSums& sums) const {
  sums.unit = unit_;
  for (std::size_t i = 0; i < system_.homes; ++i) {
    const double inverse_mass = system_.bodies[i].inverse_mass;
    if (inverse_mass == 0) continue;
    const Motion now = motion_of(system_.bodies[i]);
    double uphill[2] = {0, 0}, progress[2] = {0, 0};
    for (std::size_t k = 0; k < 6; ++k) {
      const double step = now[k] - start_[i][k];
      uphill[k / 3] -= step * (now[k] - before_[i][k]), progress[k / 3] += step * step;
    }
    const double inertia = inertia_of(system_, i);
    const SweepTerms<double> terms{uphill[0] / inverse_mass + uphill[1] * inertia,
                                   progress[0] / inverse_mass + progress[1] * inertia, sums.change};
    add_terms(sums, terms, true);
  }
}

double SweepMomentum::largest_share(double progress) {
  const double before = std::exchange(progress_, progress);
  if (!(before > progress)) return 1;
  const double contraction = std::sqrt(progress / before);
  return contraction / (2 - contraction);
}

void SweepMomentum::extrapolate(const SweepSums& sums) {
  const double nesterov = momentum_.next(is_first_ ? SweepSums{} : sums, !is_first_).momentum;
  const double share = std::min(nesterov, largest_share(is_first_ ? 0 : static_cast<double>(sums.progress) * sums.unit));
  is_first_ = false, unit_ = unit_for(sums.largest);  // anew each time: the error may fall by more than a unit's 2^-30
  for (std::size_t i = 0; i < before_.size(); ++i) {
    SolverBody& body = system_.bodies[i];
    const Motion now = motion_of(body);
    for (std::size_t k = 0; k < 6; ++k) start_[i][k] = now[k] + share * (now[k] - before_[i][k]);
    before_[i] = now;
    std::copy_n(start_[i].begin(), 3, body.v), std::copy_n(start_[i].begin() + 3, 3, body.w);
  }
  double* before = unknowns_.data();
  for_each_acting(system_, [&](auto, auto& batch) {
    batch.for_each_unknown([&](std::span<double> x) {
      for (double& value : x) {
        const double now = value;
        value = now + share * (now - *before), *before++ = now;
      }
    });
  });
}

}  // namespace unibody
