#include "step/error_estimate.hpp"

#include <algorithm>
#include <limits>
#include <optional>

#include "constraints/recall.hpp"
#include "core/exact_sum.hpp"
#include "joints/joint_set.hpp"
#include "solve/friction_postprocess.hpp"
#include "solve/surface_guard.hpp"
#include "step/assemble.hpp"
#include "step/breaking.hpp"
#include "step/build.hpp"
#include "step/detect.hpp"
#include "step/division.hpp"
#include "step/prescribed.hpp"
#include "step/pressed_areas.hpp"
#include "step/stages.hpp"
#include "step/steadying.hpp"
#include "step/turning.hpp"

namespace unibody {

namespace {

// A reference takes rounds of iterations, each twice as long as the one before, so that momentum may grow. It ends when the
// natural residual is small enough, when two rounds one after the other have not halved it, not before the fifth, or after the
// last round.
constexpr int first_round = 100, least_rounds = 5, idle_rounds = 2;
constexpr double share_of_tolerance = 1e-6;

struct Effort {
  int first_round, rounds;
  double enough;         // m, natural residual
  double tolerance = 0;  // m, at which a round stops
};

Effort full_effort(const RankState& state, const StepPlan& plan) {
  return {std::max(first_round, state.scene.solver.iterations.value_or(first_round)), 8, share_of_tolerance * plan.tolerance};
}

// A sample is one round of iterations, so many times as long as the step's own, and no shorter than the least. It ends early
// where the residual has fallen to this share of the step's.
constexpr int sample_length = 8, least_sample = 80;
constexpr double sample_depth = 0.1;
constexpr double most_left = 0.75;  // of the residual, when it is said how far the error goes beyond what the sample shows

Effort effort_of_sample(const StepReport& step) {
  const double enough = sample_depth * step.residual;
  return {std::max(least_sample, sample_length * step.iterations), 1, enough, enough};
}

Vec3 linear(const SolverBody& b) { return {b.v[0], b.v[1], b.v[2]}; }
Vec3 angular(const SolverBody& b) { return {b.w[0], b.w[1], b.w[2]}; }

// m dv.dv + dw.I dw (J)
double twice_energy(const World& world, std::size_t i, const SolverBody& one, const SolverBody& other) {
  const BodyProperties& body = world.properties[i];
  const double of_motion = body.mass * (linear(one) - linear(other)).squaredNorm();
  if (body.shape.kind == ShapeKind::particle) return of_motion;
  const Vec3 spin = world.orientation_of(i).conjugate() * (angular(one) - angular(other));
  return of_motion + body.inertia.dot(spin.cwiseProduct(spin));
}

bool has_iterative_joints(const RankState& state) {
  return state.traits.has_joints && state.scene.solver.joints == JointSolve::iterative;
}

// Solves the rows of the position stage, on the multipliers of both stages together (Stages::together): what a step with any
// number of iterations is after. What follows on a solve, the guard of surfaces and friction after the solve, the converged step
// has too. Starts from the system as it is. `predicted`: velocities before the solve, of a scene whose constraints may turn in
// the step (turning.hpp), else empty. What the constraints miss of their turning is then part of the residual, and once their
// rows are solved, the rounds go on in the total form.
ConvergedStep converge(RankState& state, System& system, StepPlan plan, const StepFacts& facts, SolveFunction solver,
                       const Effort& effort, std::span<const Vec4d> predicted) {
  plan.islands = Islands::all;
  ConvergedStep converged;
  std::vector<SolverBody> best(system.bodies.begin(), system.bodies.end());
  std::vector<ContactBatch::Impulse> impulses(state.contacts.points.size());
  system.contacts().get_impulses(impulses);
  int length = effort.first_round;
  for (int round = 0, idle = 0;
       round < effort.rounds && (round < least_rounds || idle < idle_rounds) && converged.residual > effort.enough;
       ++round, length *= 2) {
    converged.iterations +=
        run_stage(state, system, plan, facts, Stage::Kind::position, solver, length, effort.tolerance).iterations;
    StepReport now;
    measure_solution(state, system, plan, now);
    std::optional<Turning> turning;
    if (!predicted.empty()) turning.emplace(state, system, predicted);
    const double whole = turning ? std::max(now.residual, turning->distance()) : now.residual;
    idle = whole <= 0.5 * converged.residual ? 0 : idle + 1;
    if (whole < converged.residual) {
      converged.residual = whole;
      best.assign(system.bodies.begin(), system.bodies.end());
      system.contacts().get_impulses(impulses);
    }
    if (turning && now.residual < StopRule::share_of_hidden * turning->distance()) turning->apply(state, system);
  }
  system.bodies.assign(best.begin(), best.end());
  if (state.has_surfaces())
    SurfaceGuard(state.world, state.search.surfaces, state.search.settings, &state.scratch).hold(system.bodies, state.halo);
  if (state.scene.solver.friction == FrictionModel::postprocess) {
    system.contacts().set_impulses(impulses);
    postprocess_friction(state.world, state.contacts, system, state.exchange);
  }
  const auto& moving = system.moving.empty() ? system.bodies : system.moving;
  converged.moving.assign(moving.begin(), moving.begin() + static_cast<std::ptrdiff_t>(state.world.homes));
  return converged;
}

// From where the step's own iterations ended, with its own layout of the constraints. The world's velocities are set in place,
// since the Vec lies over them.
ConvergedStep solve_on(RankState& state, System& system, const StepPlan& plan, const StepFacts& facts, const SolvedStep& solved,
                       const Effort& effort) {
  const std::vector<SolverBody> taken(system.bodies.begin(), system.bodies.end());
  const std::vector<SolverBody> taken_moving(system.moving.begin(), system.moving.end());
  const std::vector<Vec3> velocity_after = state.world.velocity;
  system.bodies.assign(solved.solved.begin(), solved.solved.end());
  system.moving.clear();
  for_each_batch(system.batches, [](auto, auto& batch) { batch.join_stages(); });
  std::copy(solved.velocity_before.begin(), solved.velocity_before.end(), state.world.velocity.begin());
  if (state.coarse.exists()) {  // sweeps keep what Newton's method left the momenta off by
    constexpr int longer = 8;   // than the step's own
    StepPlan deeper = plan;
    deeper.iterations *= longer, deeper.tolerance = effort.enough;
    solve_coarse_level(state, system, deeper, solved.predicted);
  }
  std::pmr::vector<Vec4d> predicted(&state.scratch);
  if (state.traits.has_centre_constraints && state.scene.solver.level != Level::velocity)
    predicted = velocities_of(solved.predicted, &state.scratch);
  const SolveFunction same_layout = state.solver.sweeps_by_colour ? state.solver.solve : accelerated_jacobi;  // converges faster
  const ConvergedStep converged = converge(state, system, plan, facts, same_layout, effort, predicted);
  system.bodies.assign(taken.begin(), taken.end());
  system.moving.assign(taken_moving.begin(), taken_moving.end());
  std::copy(velocity_after.begin(), velocity_after.end(), state.world.velocity.begin());
  return converged;
}

// The solver that converges where others take for ever: a chain of n links takes local ones some n^2 iterations.
Scene scene_of_reference(const RankState& state) {
  Scene scene = state.scene;
  scene.solver.name = "accelerated_jacobi";
  scene.solver.order = Order::coloured;
  scene.solver.joints = JointSolve::direct;
  scene.solver.warm_start = 1;
  scene.solver.scaling = 1;
  scene.joint_trees = plant_trees(scene.joints, [&](Id id) {
    const Slot slot = state.world.find(id);  // what does not move is on every rank
    return slot >= 0 && state.world.is_static(slot);
  });
  return scene;
}

// Whether that solver would do anything else than solve_on(). Where constraints have the incremental form, what they converge to
// depends on the way: there is no other one to it.
bool has_other_reference(const RankState& state) {
  const bool is_total = state.rows.form == Form::total && (state.scene.solver.form == Form::total || state.traits.only_solids);
  const bool any_way = !state.traits.has_centre_constraints || is_total || state.scene.solver.level == Level::velocity;
  return any_way && (state.solver.sweeps_by_colour || has_iterative_joints(state));
}

// The bodies at the start of the step.
World world_before(const World& world, const SolvedStep& solved) {
  std::vector<Body> homes, statics;
  for (std::size_t i = 0; i < world.size(); ++i) {
    if (!world.is_home(static_cast<Slot>(i)) && !world.is_static(static_cast<Slot>(i))) continue;
    Body body = world.body(i);
    body.state.velocity = solved.velocity_before[i];
    (i < world.homes ? homes : statics).push_back(body);
  }
  return make_world(homes, statics, world.has_rotations, world.period);
}

// The history that the step ended with, for another list of joints: whole trees, more than here.
void take_history(const RankState& state, const SolvedStep& solved, RankState& other) {
  History history = state.history;
  remember(history.contacts(), state.world, state.contacts, solved.impulses, state.step());
  history.joints() = other.history.joints();
  for (std::size_t k = 0; k < other.ties.joints.size(); ++k) {
    const auto here = std::lower_bound(state.ties.joints.begin(), state.ties.joints.end(), other.ties.joints[k]);
    if (here != state.ties.joints.end() && *here == other.ties.joints[k])
      history.joints()[k] = state.history.joints()[static_cast<std::size_t>(here - state.ties.joints.begin())];
  }
  other.history = std::move(history);
}

// The same step on a system of its own, from the multipliers that the step ended with.
ConvergedStep solve_anew(const RankState& state, const SolvedStep& solved, std::span<const double> geometric_stiffness) {
  const Scene scene = scene_of_reference(state);
  PhaseClock clock;
  RankState other(state.comm(), scene, clock, state.exchange.shares_memory());
  set_step_length(other, state.step());  // of a part, where the step is divided
  System system(&other.scratch);
  other.world = world_before(state.world, solved);
  other.when.steps_done = state.when.steps_done, other.when.in_step = state.when.in_step;
  other.traits.smallest_size = state.traits.smallest_size;
  other.search.settings.margin = state.search.settings.margin;
  set_loads(other);
  make_constraints(other);
  take_history(state, solved, other);
  know_breaks(other);
  refresh_guests(other);
  build_lasting(other, system);
  measure_pressed_areas(other);
  find_contacts(other);
  std::vector<double> own_stiffness(other.world.size() + 1, 0.0);
  if (!geometric_stiffness.empty()) std::copy_n(geometric_stiffness.begin(), state.world.homes, own_stiffness.begin());
  ConvergedStep converged;
  const Scratch::Frame frame(other.scratch);
  take_steadily(other, system, own_stiffness, [&] {
    predict(other, system);
    assemble(other, system, own_stiffness);
    const StepFacts facts = facts_of(other, system);
    const StepPlan plan = unibody::plan(scene.solver, other.traits, facts);
    warm_start(other, system, plan);
    converged = converge(other, system, plan, facts, accelerated_jacobi, full_effort(other, plan), {});
    system.batch<JointBatch>().remember(other.history.joints(), 0);
  });
  system.clear(&other.scratch);
  return converged;
}

ConvergedStep converged_step(RankState& state, System& system, const StepPlan& plan, const StepFacts& facts,
                             const SolvedStep& solved) {
  const Effort effort = full_effort(state, plan);
  ConvergedStep best;
  const auto take = [&](ConvergedStep found) {
    const int iterations = best.iterations + found.iterations;
    if (!(best.residual <= found.residual)) best = std::move(found);
    best.iterations = iterations;
  };
  const bool other = has_other_reference(state);
  if (other && has_iterative_joints(state)) take(solve_anew(state, solved, state.rows.geometric_stiffness));
  if (!(best.residual <= effort.enough)) take(solve_on(state, system, plan, facts, solved, effort));
  if (other && !has_iterative_joints(state) && !(best.residual <= effort.enough))
    take(solve_anew(state, solved, state.rows.geometric_stiffness));
  return best;
}

StepError error_beside(const RankState& state, const System& system, const SolvedStep& solved, const ConvergedStep& converged) {
  const World& world = state.world;
  const auto& moving = system.moving.empty() ? system.bodies : system.moving;
  std::array<ExactSum, 3> sums;
  for (std::size_t i = 0; i < world.homes; ++i) {
    if (system.bodies[i].inverse_mass == 0) continue;
    sums[0] += twice_energy(world, i, moving[i], converged.moving[i]);
    sums[1] += twice_energy(world, i, solved.predicted[i], converged.moving[i]);
    sums[2] += world.properties[i].mass;
  }
  StepError error;
  error.reference_residual = converged.residual, error.iterations = converged.iterations;
  const auto total = all_sums(state.comm(), sums);
  if (total[2] > 0) error.distance = state.step() * std::sqrt(total[0] / total[2]);
  if (total[1] > 0) error.relative = std::sqrt(total[0] / total[1]);
  return error;
}

}  // namespace

StepError estimate_error(RankState& state, System& system, const StepPlan& plan, const StepFacts& facts,
                         const SolvedStep& solved) {
  const PhaseClock::Scope scope(state.clock, Phase::other);  // no part of the step's own time
  return error_beside(state, system, solved, converged_step(state, system, plan, facts, solved));
}

double sample_error(RankState& state, System& system, const StepPlan& plan, const StepFacts& facts, const SolvedStep& solved,
                    const StepReport& step) {
  const Effort effort = effort_of_sample(step);
  if (!(step.residual > 0)) return 0;
  const Batches kept = system.batches;
  const StepError error = error_beside(state, system, solved, solve_on(state, system, plan, facts, solved, effort));
  system.batches = kept;
  const double left = error.reference_residual / step.residual;
  return error.distance / (1 - std::min(left, most_left));
}

}  // namespace unibody
