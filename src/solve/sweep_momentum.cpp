#include "solve/sweep_momentum.hpp"

#include <algorithm>
#include <bit>
#include <utility>

#include "solve/sum_reduction.hpp"

namespace unibody {

namespace {

// What resists turning (kg m^2): exact where the inertia is the same about all axes, else a mean, which the restart tests take.
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
  for (std::size_t i = 0; i < system.first_static; ++i) before_[i] = start_[i] = std::bit_cast<Motion>(system.bodies[i]);
  std::size_t count = 0;
  for_each_acting(system, [&](auto, auto& batch) { batch.for_each_unknown([&](std::span<double> x) { count += x.size(); }); });
  unknowns_.reserve(count);
  for_each_acting(system, [&](auto, auto& batch) {
    batch.for_each_unknown([&](std::span<double> x) { unknowns_.insert(unknowns_.end(), x.begin(), x.end()); });
  });
}

void SweepMomentum::measure(SweepSums& sums) const {
  sums.unit = unit_;
  const auto product = [](Vec4d a, Vec4d b) {
    const Vec4d c = a * b;
    return c[0] + c[1] + c[2];
  };
  for (std::size_t i = 0; i < system_.homes; ++i) {
    const double inverse_mass = system_.bodies[i].inverse_mass;
    if (inverse_mass == 0) continue;
    const auto now = std::bit_cast<Motion>(system_.bodies[i]);
    const Vec4d step = now.linear - start_[i].linear, mass = broadcast(1 / inverse_mass);
    SweepTerms<double> terms{-product(mass * step, now.linear - before_[i].linear), product(mass * step, step), sums.change};
    if (system_.rotates) {
      const Vec4d turn = now.angular - start_[i].angular, inertia = broadcast(inertia_of(system_, i));
      terms.gradient -= product(inertia * turn, now.angular - before_[i].angular);
      terms.progress += product(inertia * turn, turn);
    }
    add_terms(sums, terms, true);
  }
}

double SweepMomentum::largest_share(double progress) {
  const double before = std::exchange(progress_, progress);
  if (!(before > progress)) return 1;
  return progress / before;
}

void SweepMomentum::extrapolate(const SweepSums& sums) {
  const double nesterov = momentum_.next(is_first_ ? SweepSums{} : sums, !is_first_).momentum;
  const double share = std::min(nesterov, largest_share(is_first_ ? 0 : static_cast<double>(sums.progress) * sums.unit));
  is_first_ = false, unit_ = unit_for(sums.largest);  // anew each time: the error may fall by more than a unit's 2^-30
  const Vec4d part = broadcast(share);
  for (std::size_t i = 0; i < before_.size(); ++i) {
    const auto now = std::bit_cast<Motion>(system_.bodies[i]);
    start_[i] = {now.linear + part * (now.linear - before_[i].linear), now.angular + part * (now.angular - before_[i].angular)};
    before_[i] = now, system_.bodies[i] = std::bit_cast<SolverBody>(start_[i]);
  }
  double* before = unknowns_.data();
  for_each_acting(system_, [&](auto, auto& batch) {
    batch.for_each_unknown([&](std::span<double> x) {
      for (std::size_t k = 0; k < x.size(); ++k) {
        const double now = x[k];
        x[k] = now + share * (now - before[k]), before[k] = now;
      }
      before += x.size();
    });
  });
}

}  // namespace unibody
