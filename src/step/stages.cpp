#include "step/stages.hpp"

#include <algorithm>
#include <array>

#include "constraints/creep.hpp"
#include "core/checked.hpp"
#include "core/largest.hpp"
#include "solve/friction_postprocess.hpp"
#include "solve/surface_guard.hpp"
#include "step/accuracy.hpp"
#include "step/contact_forces.hpp"
#include "step/contact_problem.hpp"
#include "step/error_estimate.hpp"
#include "step/steadying.hpp"
#include "step/struck.hpp"
#include "step/turning.hpp"

namespace unibody {

void warm_start(RankState& state, System& system, const StepPlan& plan) {
  WarmStart warm;
  warm.contacts_share = warm.free_contacts_share = plan.contacts_share, warm.share = plan.share;
  if (plan.islands == Islands::constrained)
    warm.free_contacts_share = plan_of_free_islands(state.scene.solver, state.traits, {}).contacts_share;
  warm.setting = state.scene.solver.warm_start.value_or(-1);
  if (plan.solids_start_cold) warm.cold_solids = &state.search.surfaces;
  {
    const Scratch::Frame frame(state.scratch);
    for_each_batch(system.batches,
                   [&](auto place, auto& batch) { batch.start_from(std::get<decltype(place)::value>(state.history), warm); });
  }
  const bool jacobi = !state.solver.sweeps_by_colour;
  const std::size_t n = state.world.size() + 1;
  const SceneTraits& traits = state.traits;
  if (jacobi && (!state.is_alone() || traits.has_attachments || traits.has_joints)) system.wrenches.assign(n, Wrench{});
  if (traits.has_centre_constraints && (jacobi || warm.share > 0)) system.impulses.assign(n, Vec4d{});
  if (!warm.has_contacts() && warm.share <= 0 && state.ties.pressed_areas.empty()) return;
  const Scratch::Frame frame(state.scratch);
  const bool borrowed =
      !jacobi && (warm.has_contacts() || traits.has_joints || traits.has_attachments) && system.wrenches.empty();
  if (borrowed) system.wrenches.assign(n, Wrench{});
  for_each_batch(system.batches, [&](auto, auto& batch) { batch.add_impulses(system, warm, plan.most_stiffness); });
  system.apply_wrenches();
  if (borrowed) system.wrenches = std::pmr::vector<Wrench>(&state.scratch);
  if (!jacobi) system.impulses.clear();
  state.exchange.refresh(system.bodies);
}

// Lets bounces pay for what contacts beside them have gained (ContactBatch::add_gains). Returns whether any does. Collective.
bool charge_gains(RankState& state, System& system) {
  const std::size_t n = state.world.size() + 1;
  std::vector<ContactBatch::Gain> gains(n);
  if (!state.any_over_ranks(system.contacts().add_gains(system.bodies, gains))) return false;
  std::vector<double> work(n), bounces(n);
  for (std::size_t i = 0; i < n; ++i) work[i] = gains[i].work, bounces[i] = gains[i].bounces;
  state.exchange.refresh(std::span(work)), state.exchange.refresh(std::span(bounces));
  for (std::size_t i = 0; i < n; ++i) gains[i] = {work[i], bounces[i]};
  system.contacts().charge_bounces(gains);
  return true;
}

SolveReport run_stage(RankState& state, System& system, const StepPlan& plan, const StepFacts& facts, Stage::Kind kind,
                      SolveFunction solver, int iterations, const StopRule& rule) {
  const Stage stage = plan.stage(kind, state.scene.solver, state.step());
  start_stage(system, stage);
  system.keeps_places = kind == Stage::Kind::position && plan.islands != Islands::free && state.traits.has_centre_constraints;
  system.acceleration = kind == Stage::Kind::velocity ? plan.velocity_acceleration : plan.position_acceleration;
  system.renews = stage.reevaluates || facts.bounces || state.traits.complies;
  const int first = facts.bounces ? iterations - iterations / 3 : iterations;
  SolveReport report = solver(system, state.exchange, first, rule);
  if (facts.bounces) {
    const bool pays = charge_gains(state, system), stopped = report.iterations < first;
    if (const int left = iterations - report.iterations; left > 0 && (pays || !stopped)) {
      report = solver(system, state.exchange, left, rule);
      report.iterations += iterations - left;
    }
    const bool borrowed = system.wrenches.empty();
    if (borrowed) system.wrenches.assign(state.world.size() + 1, Wrench{});
    for_each_acting(system, [&](auto, auto& batch) { batch.give_back_gains(system); });
    system.apply_wrenches();
    if (borrowed) system.wrenches.clear();
    state.exchange.refresh(system.bodies);
  }
  if (system.renews) for_each_acting(system, [&](auto, auto& batch) { batch.renew(system); });
  return report;
}

void measure_solution(const RankState& state, const System& system, const StepPlan& plan, StepReport& report, double left) {
  std::array<double, BatchTypes::size + 1> largest{};
  std::ranges::copy(residuals(system), largest.begin());
  largest.back() = left;
  make_largest(state.comm(), largest);
  std::copy_n(largest.begin(), BatchTypes::size, report.batch_residuals.begin());
  report.residual = *std::ranges::max_element(largest);
  report.converged = report.residual <= plan.tolerance;
}

namespace {

// m. A manifold counts as solved where its own residual is no more than this share of the automatic tolerance, whatever the
// scene's: one that is at the tolerance may stand in a column that as a whole is far from solved.
double solved_residual(const RankState& state) {
  constexpr double share = 0.15;
  return share * tolerance_of_contacts(state.traits);
}

// The leak of this step, and what is taken back of its impulses, where the contacts that the position stage pushed on open
// together. A pile that is deeper than the velocity stage reaches in a step answers the leak too slowly: once it has sunk, the
// impulses that have gathered throw it up, and further each time. Two things hinder that. The leak is withheld while the pile
// rises: by U S against the solver's share of g h, where U is the contacts' mean opening speed and S, from 0 to 1, the part of it
// that is coherent. And the impulses themselves, which are more than the pile weighs, are taken back by a share that grows with
// U S^4; the fourth power keeps it small where bodies merely jostle. So what few iterations leave undone gives no energy.
double leak_of(const RankState& state, System& system, const StepPlan& plan) {
  constexpr double unloading = 8;  // share of the impulses for each g h of coherent speed
  const double gh = state.traits.gravity * state.step();
  if (plan.leak == 0 || plan.swelling == 0 || gh == 0) return plan.leak;
  const std::vector<double> sums = all_sums(state.comm(), system.contacts().opening(system.bodies));
  if (!(sums[0] > 0)) return plan.leak;
  const double speed = sums[0] / sums[2] / gh, coherence = sums[0] / sums[1], squared = coherence * coherence;
  system.contacts().unload(std::max(0.0, 1 - unloading * speed * squared * squared));
  return plan.leak * std::max(0.0, 1 - speed * coherence / plan.swelling);
}

SolvedStep solved_step(const System& system, SolvedStep before) {
  before.solved.assign(system.bodies.begin(), system.bodies.end());
  before.impulses = system.contacts().total_impulses();
  return before;
}

// Pairs held apart by the guard and friction after the solve; what the step leaves to the next one, and what slides.
void follow_up(RankState& state, System& system, const StepPlan& plan, double leak, StepReport& report) {
  const bool pile = plan.two_stages && !state.traits.has_constraints();
  system.contacts().note_creep(system.bodies, pile ? least_points_in_piles : 1);
  if (state.has_surfaces())
    report.guard =
        SurfaceGuard(state.world, state.search.surfaces, state.search.settings, &state.scratch).hold(system.bodies, state.halo);
  if (state.scene.solver.friction == FrictionModel::postprocess)
    report.sliding = postprocess_friction(state.world, state.contacts, system, state.exchange);
  for_each_batch(system.batches, [&](auto place, auto& batch) {
    report.sliding += batch.sliding();
    batch.remember(std::get<decltype(place)::value>(state.history), leak);
  });
  forget_multipliers(state);
  if (state.is_alone()) return;
  std::array<std::int64_t, 2> counts{report.sliding, state.impacts.count};
  check_mpi(MPI_Allreduce(MPI_IN_PLACE, counts.data(), 2, MPI_INT64_T, MPI_SUM, state.comm()));
  report.sliding = counts[0], report.impacts = counts[1];
}

}  // namespace

namespace {

struct StagesDone {
  int iterations = 0;
  double leak = 0;                // of the position stage's multipliers, into what the next step starts from
  double left_by_velocities = 0;  // m, the residual that the velocity stage left
  double turning = 0;             // m, what constraints miss of it
  CoarseSolve coarse;             // what its momenta are off by no sweep sees
  WorstConstraint worst;          // of the velocity stage on this rank, where it left more than is to be named
};

const WorstConstraint& worse_of(const WorstConstraint& a, const WorstConstraint& b) { return b.precedes(a) ? b : a; }

// What there was before the warm start: the bodies where the scene has a coarse level, velocities where it has constraints
// between centres.
struct Predicted {
  std::vector<SolverBody> bodies;
  std::pmr::vector<Vec4d> velocities;
};

// The stages of a plan, in its islands.
StagesDone run_stages(RankState& state, System& system, const StepPlan& plan, const StepFacts& facts, double name_above,
                      const Predicted& predicted) {
  const auto run = [&](Stage::Kind kind, int iterations, const StopRule& rule) {
    return run_stage(state, system, plan, facts, kind, state.solver.solve, iterations, rule);
  };
  StagesDone done;
  bool leaks = false;
  if (plan.two_stages) {
    const StopRule rule(plan.aim, plan.tolerance, plan.least_of(Stage::Kind::velocity));
    const SolveReport velocity = run(Stage::Kind::velocity, plan.velocity_iterations, rule);
    done.iterations = velocity.iterations, leaks = !velocity.converged;
    if (leaks && plan.uneven_share < 1) system.contacts().even_out(system.bodies, solved_residual(state), plan.uneven_share);
    if (plan.stages == Stages::two) done.left_by_velocities = std::ranges::max(residuals(system));
    if (done.left_by_velocities > name_above) done.worst = worst_constraint(system, state.world);
    for_each_batch(system.batches, [&]<class B>(auto, B& batch) {
      if (B::in_free_islands || plan.islands != Islands::free) batch.keep_impulses(plan.stages == Stages::together);
    });
  }
  if (state.coarse.exists() && plan.islands != Islands::free)
    done.coarse = solve_coarse_level(state, system, plan, predicted.bodies);
  StopRule rule(plan.aim, plan.tolerance, plan.least_of(Stage::Kind::position));
  const bool turns = !predicted.velocities.empty() && plan.islands != Islands::free;
  const bool goes_on = turns && !state.coarse.exists();  // which keeps the momenta itself
  if (goes_on) rule.hidden = [&] { return Turning(state, system, predicted.velocities).distance(); };
  done.iterations += run(Stage::Kind::position, plan.iterations - done.iterations, rule).iterations;
  if (turns) {
    rule.hidden = nullptr;
    const TurningLeft left =
        take_out_turning(state, system, predicted.velocities, plan.tolerance, goes_on ? plan.iterations - done.iterations : 0,
                         [&](int most) { return run(Stage::Kind::position, most, rule).iterations; });
    done.iterations += left.iterations, done.turning = left.distance;
  }
  if (!plan.two_stages) return done.leak = 1, done;  // in islands with one stage, all is remembered
  if (!leaks) return done;
  const double weight = state.traits.gravity * state.step();
  if (plan.most_weights > 0 && weight > 0) system.contacts().limit_leak(system.bodies, plan.most_weights, weight);
  done.leak = leak_of(state, system, plan);
  return done;
}

}  // namespace

StepReport solve(RankState& state, System& system, const StepPlan& plan, const StepFacts& facts, const StepRequest& request) {
  const bool samples = samples_error(state), wanted = request.error || request.problem != nullptr || samples;
  SolvedStep solved;
  if (wanted) {
    solved.predicted.assign(system.bodies.begin(), system.bodies.end());
    solved.velocity_before = state.world.velocity;
  }
  Predicted predicted;
  if (state.coarse.exists()) predicted.bodies.assign(system.bodies.begin(), system.bodies.end());
  if (state.traits.has_centre_constraints && state.scene.solver.level != Level::velocity) {
    set_form(state, system, state.rows.form);  // the last step may have ended in the total one
    predicted.velocities = velocities_of(system.bodies, &state.scratch);
  }
  warm_start(state, system, plan);

  const StagesDone done = run_stages(state, system, plan, facts, request.name_above, predicted);
  StagesDone free;
  StepReport report;
  report.plans = {plan};
  if (plan.islands == Islands::constrained) {
    const StepPlan of_free = plan_of_free_islands(state.scene.solver, state.traits, facts);
    report.plans.push_back(of_free);
    free = run_stages(state, system, of_free, facts, request.name_above, predicted);
    system.contacts().set_free_leak(free.leak);
    take_all_islands(system);
    if (system.renews) for_each_acting(system, [&](auto, auto& batch) { batch.renew(system); });
  }
  report.iterations = std::max(done.iterations, free.iterations);
  measure_solution(state, system, plan, report, std::max({done.left_by_velocities, free.left_by_velocities, done.coarse.off}));
  report.turning = done.turning;
  report.converged = report.converged && report.turning <= plan.tolerance;
  report.coarse = done.coarse.counts;
  if (request.may_be_outrun && find_struck(state, system)) {
    report.outrun = true;
    return report;
  }
  if (report.residual > request.name_above)
    report.worst =
        worst_over_ranks(state.comm(), worse_of(worst_constraint(system, state.world), worse_of(done.worst, free.worst)));
  if (wanted) solved = solved_step(system, std::move(solved));
  if (request.problem != nullptr) *request.problem = contact_problem_of(state, system, plan, solved);
  if (request.impulses) report.impulses = contact_impulses(state, system);
  follow_up(state, system, plan, done.leak, report);
  if (samples)
    take_sample(state, sample_error(state, system, plan, facts, solved, report), plan.tolerance, report);
  else if (state.scene.solver.accuracy)
    estimate_by_ratio(state, report);
  report.estimated_error = std::max(report.estimated_error, state.scene.solver.accuracy ? report.turning : 0);
  if (request.error) report.error = estimate_error(state, system, plan, facts, solved);
  return report;
}

}  // namespace unibody
