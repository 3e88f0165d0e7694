// Gauss-Seidel: every constraint acts on the velocities that the ones before it have left. Coloured, so that the same sweep runs
// four constraints at a time and on any number of ranks. Every second sweep goes through the colours of contacts backwards, which
// halves its bias; all else always goes forwards: backwards the last colour would be solved twice in a row, which of few colours
// wastes much (twice the stretch of a cloth). Contacts of surfaces are one colour, within which all move at once, by masses
// split among them, and therefore some times over; attachments are another, and so are the trees of joints that are solved
// directly.

#include <algorithm>
#include <optional>
#include <vector>

#include "solve/solver.hpp"
#include "solve/stop_test.hpp"
#include "solve/sum_reduction.hpp"
#include "solve/sweep_momentum.hpp"

namespace unibody {

namespace {

// One colour of a batch.
struct Pass {
  std::size_t batch, colour;
  bool needs_all;  // before it, all shared bodies are refreshed rather than those of the colour
};

// The passes of one iteration, in their order. The first `alternating` ones are taken backwards in every second iteration.
struct Schedule {
  std::vector<Pass> passes;
  std::size_t alternating = 0;

  const Pass& at(std::size_t i, bool backwards) const { return passes[backwards && i < alternating ? alternating - 1 - i : i]; }
};

Schedule make_schedule(const System& system) {
  Schedule schedule;
  for_each_acting(system, [&]<class B>(auto place, const B& batch) {
    if constexpr (B::follows) return;  // with the passes of the batch before it
    for (std::size_t colour = 0; colour < batch.colours(); ++colour)
      for (int k = 0; k < B::relaxations; ++k) schedule.passes.push_back({place, colour, batch.needs_all(colour)});
    if constexpr (B::alternates) schedule.alternating = schedule.passes.size();
  });
  return schedule;
}

double relax(System& system, const Pass& pass, bool backwards) {
  double change = 0;
  for_each_batch(system.batches, [&]<class B>(auto place, B& batch) {
    const bool is_next = B::follows && place == pass.batch + 1;
    if (place == pass.batch || is_next) change = std::max(change, batch.relax(pass.colour, backwards, system));
  });
  return change;
}

// All passes of an iteration; returns the largest change (m) on this rank.
double sweep(System& system, const Exchange& exchange, const Schedule& schedule, bool backwards) {
  double change = 0;
  for (std::size_t i = 0; i < schedule.passes.size(); ++i) {
    const Pass& pass = schedule.at(i, backwards);
    if (pass.needs_all)
      exchange.refresh(system.bodies);
    else
      exchange.refresh(pass.batch, pass.colour, system.bodies);
    change = std::max(change, relax(system, pass, backwards));
  }
  return change;
}

}  // namespace

SolveReport gauss_seidel(System& system, const Exchange& exchange, int iterations, const StopRule& rule) {
  SolveReport report;
  const Schedule schedule = make_schedule(system);
  StopTest stop(system, exchange, rule);
  bool stopped = false;
  SumReduction reduction(exchange);
  std::optional<SweepMomentum> momentum;
  if (system.acceleration != Acceleration::none) momentum.emplace(system);
  while (report.iterations < iterations && !stopped) {
    if (system.observer) system.observer();
    if (system.renews) {
      exchange.refresh(system.bodies);
      for_each_acting(system, [&](auto, auto& batch) { batch.renew(system); });
    }
    const bool backwards = report.iterations % 2 == 1;
    SweepSums sums;
    sums.change = sweep(system, exchange, schedule, backwards);
    ++report.iterations;
    // What is applied in the end must lie in the cone: two plain sweeps at least follow where it was left.
    const bool extrapolates = momentum && backwards && report.iterations + 2 <= iterations;
    if (extrapolates) momentum->measure(sums);
    if (rule.tolerance <= 0 && rule.allowed <= 0 && !rule.hidden && !extrapolates) continue;
    reduction.start(sums);
    sums = reduction.wait();
    const bool measures = stop.is_worth_measuring(sums.change, report.iterations);
    if (measures || extrapolates) exchange.refresh(system.bodies);
    if (measures) stopped = stop.may_stop(sums.change, report.iterations);
    if (extrapolates && !stopped) momentum->extrapolate(sums);
  }
  report.residual = stop.residual(), report.converged = stop.passed();
  if (momentum) report.restarts = momentum->restarts();
  for_each_acting(system, [&](auto, auto& batch) { batch.end_stage(system); });
  exchange.refresh(system.bodies);
  return report;
}

}  // namespace unibody
