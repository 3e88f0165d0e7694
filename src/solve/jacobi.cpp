// Jacobi and accelerated Jacobi (paper, Algorithm 1, with the signs and the scaling corrected).
//
// Every constraint reads the velocities of the last iteration and all of them move at once. The masses are split among the
// constraints of a body, so a step length of 1 is safe; with momentum the error falls as 1/k^2 rather than 1/k.

#include "solve/momentum.hpp"
#include "solve/solver.hpp"
#include "solve/stop_test.hpp"
#include "solve/sum_reduction.hpp"

namespace unibody {

namespace {

SolveReport iterate(System& system, const Exchange& exchange, int iterations, const StopRule& rule, bool accelerated) {
  SolveReport report;
  SumReduction reduction(exchange);
  Momentum momentum(system.acceleration);
  StopTest stop(system, exchange, rule);
  bool stopped = false;
  double unit = 1;
  if (system.keeps_places) system.move_places();
  for (int k = 0; k < iterations && !stopped; ++k) {
    Extrapolation extrapolation;
    bool measures = false;
    double change = 0;
    if (k > 0) {
      const SweepSums& sums = reduction.wait();
      change = sums.change, measures = stop.is_worth_measuring(change, k);
      if (accelerated) extrapolation = momentum.next(sums, k > 1);
      if (k == 1) unit = unit_for(sums.largest);
    } else if (accelerated) {
      extrapolation = momentum.next({}, false);
    }
    const bool last = k == iterations - 1;
    if (last || measures) extrapolation = {};  // what is applied in the end must lie in the cone

    if (system.observer) system.observer();
    if (system.renews) for_each_acting(system, [&](auto, auto& batch) { batch.renew(system); });
    SweepSums sums;
    sums.unit = unit;
    for_each_acting(system, [&](auto, auto& batch) { batch.sweep(system, extrapolation, sums); });
    reduction.start(sums);
    system.apply_wrenches();
    if (last) for_each_acting(system, [&](auto, auto& batch) { batch.end_stage(system); });
    exchange.refresh(system.bodies);
    if (system.keeps_places) system.move_places(system.homes);
    ++report.iterations;
    if (last || !measures) continue;
    stopped = stop.may_stop(change, k);
    if (!stopped) continue;
    for_each_acting(system, [&](auto, auto& batch) { batch.end_stage(system); });
    exchange.refresh(system.bodies);
  }
  report.residual = stop.residual(), report.converged = stop.passed();
  report.restarts = momentum.restarts();
  return report;
}

}  // namespace

SolveReport accelerated_jacobi(System& system, const Exchange& exchange, int iterations, const StopRule& rule) {
  return iterate(system, exchange, iterations, rule, system.acceleration != Acceleration::none);
}

SolveReport jacobi(System& system, const Exchange& exchange, int iterations, const StopRule& rule) {
  return iterate(system, exchange, iterations, rule, false);
}

}  // namespace unibody
