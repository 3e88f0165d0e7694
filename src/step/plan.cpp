#include "step/plan.hpp"

#include <algorithm>
#include <cmath>

#include "scene/stiffness.hpp"
#include "solve/solver.hpp"

namespace unibody {

namespace {

bool at_velocity_level(const SolverSettings& settings) { return settings.level == Level::velocity; }

Form form_of(const SolverSettings& settings, const SceneTraits& traits) {
  if (settings.form != Form::automatic) return settings.form;
  return asks_for_stiffness(settings, traits) && traits.stiffness <= stiffest_for_total ? Form::total : Form::incremental;
}

Stages stages_of(const SolverSettings& settings, const SceneTraits& traits, const Solver& solver) {
  if (at_velocity_level(settings)) return Stages::position;
  if (settings.stages != Stages::automatic) return settings.stages;
  return traits.has_constraints() && !solver.sweeps_by_colour ? Stages::position : Stages::two;
}

// ns, of one core by the weights of partition/work.hpp: where the scene leaves it open, a step may take as many iterations as
// cost no more. Scenes of some ten bodies converge so; those of hundreds, whose default iterations cost more, take no others.
constexpr double work_of_step = 5e5;

int most_iterations(const SolverSettings& settings, std::int64_t work) {
  if (settings.iterations) return *settings.iterations;
  if (settings.accuracy) return most_automatic_iterations;
  if (settings.tolerance == 0 || work <= 0) return default_iterations;  // no step stops before its last, or: not known
  const double fit = work_of_step / static_cast<double>(work);
  return static_cast<int>(std::clamp<double>(fit, default_iterations, most_automatic_iterations));
}

// Links and joints have the position stage alone: half of the iterations are for it, whatever contacts would do with fewer.
Split split_of(const SolverSettings& settings, int iterations, const SceneTraits& traits, const Solver& solver) {
  // Sweeps without momentum reach no further down a pile than the few that leave it no time.
  const bool plain = solver.sweeps_by_colour && settings.acceleration == Acceleration::none;
  Split split = solver.split(plain ? std::min(iterations, least_for_momentum - 1) : iterations);
  if (traits.has_constraints()) split.velocity_share = std::min(split.velocity_share, 0.5);
  split.velocity_share = settings.velocity_share.value_or(split.velocity_share);
  split.leak = settings.leak.value_or(split.leak);
  return split;
}

// How a solver extrapolates in a stage. Gauss-Seidel's sweeps over membranes, tetrahedra and angles, of many colours and all in
// one direction, contract fast by themselves: momentum would cost them more than it brings, but where the material is very stiff.
Acceleration acceleration_of(const SolverSettings& settings, const SceneTraits& traits, const StepFacts& facts,
                             Stage::Kind kind) {
  if (settings.acceleration != Acceleration::automatic) return settings.acceleration;
  if (find_solver(settings.name).sweeps_by_colour) {
    const bool of_elements = kind == Stage::Kind::position && traits.has_centre_constraints && !traits.only_links;
    return of_elements ? Acceleration::none : Acceleration::nesterov;
  }
  bool bears_more = settings.scaling == 1 && !facts.bounces;
  if (kind == Stage::Kind::position)
    bears_more =
        bears_more && !traits.has_attachments && !traits.has_joints && settings.gap == Gap::frozen &&
        (!traits.has_centre_constraints || (!at_velocity_level(settings) && traits.only_links && !facts.links_are_tight));
  return bears_more ? Acceleration::optimized : Acceleration::nesterov;
}

// Of the smallest body's size, in a step of a whole frame: what the first iterations of a step with an accuracy are after. It is
// more than the automatic tolerance, since what rests is held to the accuracy by those that follow.
constexpr double aim_of_accuracy = 1e-4;

// A force moves a body in a step by the square of the step's length. The tolerance falls as that square where a frame has more
// steps: a stage then leaves the same share of the motion undone, and a body at rest creeps less per second the finer the steps
// are. What stacks creep at one step a frame is some ten tolerances a contact (constraints/creep.hpp), for which that of bodies
// with contacts alone is the smaller one. A short frame has few steps, so the tolerance is also bounded by a share of what a body
// falls in the step.
double automatic_tolerance_of(const SceneTraits& traits, double share) {
  const double part = traits.step / traits.frame, fall = traits.gravity * traits.step * traits.step;
  const double by_size = share * traits.smallest_size * part * part;
  return fall > 0 ? std::min(by_size, automatic_share_of_fall * fall) : by_size;
}

// The residual at which the error of a step is its part of what the accuracy allows a frame.
double tolerance_of_accuracy(double accuracy, const SceneTraits& traits, double error_ratio) {
  return accuracy * traits.smallest_size * (traits.step / traits.frame) / std::max(least_error_ratio, error_ratio);
}

double tolerance_of(const SolverSettings& settings, const SceneTraits& traits, const StepFacts& facts) {
  if (settings.tolerance) return *settings.tolerance;
  if (!std::isfinite(traits.smallest_size)) return 0;
  return settings.accuracy
             ? tolerance_of_accuracy(*settings.accuracy, traits, facts.error_ratio)
             : automatic_tolerance_of(traits, traits.has_constraints() ? constrained_tolerance : automatic_tolerance);
}

void plan_sizes(const SolverSettings& settings, const SceneTraits& traits, const StepFacts& facts, StepPlan& plan) {
  const double size = traits.smallest_size;
  plan.tolerance = plan.aim = tolerance_of(settings, traits, facts);
  if (settings.accuracy && plan.tolerance > 0)
    plan.aim = std::min(plan.tolerance, automatic_tolerance_of(traits, aim_of_accuracy));
  // What attracts must be found as far as it does.
  plan.margin =
      std::max(settings.margin.value_or(std::min(most_automatic_margin, automatic_margin * size)), traits.adhesion_range);
  const double toss = traits.gravity > 0 ? std::sqrt(2 * traits.gravity * (automatic_toss * size)) : HUGE_VAL;
  plan.recovery_speed = settings.recovery_speed.value_or(std::min(most_automatic_recovery_speed, toss));
  // A time of the step's own would take penetration out the faster the finer the steps are: piles would shake.
  plan.recovery_time = settings.recovery_time.value_or(traits.frame);
  // What is stretched over an edge pulls with stiff links, which ask for all of their error within the step; a contact that asked
  // for less of its own would give way to them as long as they hang there, by centimetres.
  plan.surface_recovery_time = settings.recovery_time.value_or(0);
}

// Each stage goes for the usual tolerance in as many iterations as it is meant to have of the usual number.
void plan_least_iterations(const Split& split, StepPlan& plan) {
  plan.least_velocity_iterations = plan.two_stages ? static_cast<int>(split.velocity_share * default_iterations) : 0;
  plan.least_position_iterations = default_iterations - plan.least_velocity_iterations;
}

}  // namespace

StepPlan plan(const SolverSettings& settings, const SceneTraits& traits, const StepFacts& facts) {
  const Solver& solver = find_solver(settings.name);
  StepPlan plan;
  plan_sizes(settings, traits, facts, plan);
  plan.form = form_of(settings, traits);
  plan.stages = stages_of(settings, traits, solver);
  const bool apart = facts.free_contacts && traits.has_constraints();
  plan.islands = apart ? Islands::constrained : Islands::all;
  plan.iterations = most_iterations(settings, apart ? facts.work - facts.free_work : facts.work);
  const bool any_contact = apart ? facts.constrained_contacts : facts.any_contact;
  plan.two_stages = plan.stages != Stages::position && (!traits.has_constraints() || any_contact);
  // By what the solver is meant to have: the more a stage is known to have, the sooner it forgets.
  const bool spares = !settings.iterations && !settings.accuracy && plan.iterations > default_iterations;
  const Split split = split_of(settings, spares ? default_iterations : plan.iterations, traits, solver);
  plan.velocity_share = split.velocity_share, plan.leak = split.leak;
  if (plan.two_stages)
    plan.velocity_iterations = std::clamp(static_cast<int>(split.velocity_share * plan.iterations), 1, plan.iterations - 1);
  if (settings.accuracy || spares) plan_least_iterations(split, plan);
  if (plan.two_stages && split.iterations_a_weight > 0) plan.most_weights = plan.velocity_iterations / split.iterations_a_weight;
  plan.swelling = split.swelling;

  const double share = old_share(settings, plan.iterations);
  const bool one_stage_of_velocities = at_velocity_level(settings) && !settings.warm_start;
  const double in_one_stage = one_stage_of_velocities ? automatic_velocity_share : share;
  plan.contacts_share = plan.stages != Stages::position ? 1 : in_one_stage;
  plan.uneven_share = plan.stages != Stages::position ? std::pow(split.uneven_share, traits.step / traits.frame) : 1;
  plan.share = traits.has_constraints() ? share : 0;
  plan.solids_start_cold = !settings.warm_start && plan.stages == Stages::position && !at_velocity_level(settings);

  plan.velocity_acceleration = acceleration_of(settings, traits, facts, Stage::Kind::velocity);
  plan.position_acceleration = acceleration_of(settings, traits, facts, Stage::Kind::position);
  const bool optimized = solver.solve == accelerated_jacobi && plan.position_acceleration == Acceleration::optimized;
  if (optimized && !at_velocity_level(settings)) plan.most_stiffness = most_geometric_stiffness;
  return plan;
}

Stage StepPlan::stage(Stage::Kind kind, const SolverSettings& settings, double step) const {
  // At velocity level the only stage is one of positions whose rows are linear about the start of the step.
  Stage stage = at_velocity_level(settings) ? Stage::stabilised(step, settings.stabilisation)
                                            : Stage{kind, step, recovery_time, recovery_speed, surface_recovery_time};
  stage.islands = islands;
  stage.reevaluates = kind == Stage::Kind::position && settings.gap == Gap::reevaluated;
  return stage;
}

double old_share(const SolverSettings& settings, int iterations) {
  const double part = std::min(1.0, static_cast<double>(iterations_of_share) / iterations);
  return settings.warm_start.value_or(automatic_share * part);
}

bool asks_for_stiffness(const SolverSettings& settings, const SceneTraits& traits) {
  return settings.form == Form::automatic && traits.has_solids && !settings.coarse && !at_velocity_level(settings) &&
         find_solver(settings.name).solve != nullptr;
}

bool asks_for_tight_links(const SolverSettings& settings, const SceneTraits& traits) {
  return settings.acceleration == Acceleration::automatic && find_solver(settings.name).solve == accelerated_jacobi &&
         traits.has_centre_constraints && traits.only_links;
}

bool asks_for_islands(const SolverSettings& settings, const SceneTraits& traits) {
  return traits.has_constraints() && settings.stages == Stages::automatic && !at_velocity_level(settings) &&
         find_solver(settings.name).solve != nullptr;
}

SceneTraits SceneTraits::of_free_islands() const {
  SceneTraits other = *this;
  other.has_centre_constraints = other.only_links = other.has_joints = other.has_attachments = false;
  other.has_solids = other.only_solids = false;
  return other;
}

StepPlan plan_of_free_islands(const SolverSettings& settings, const SceneTraits& traits, const StepFacts& facts) {
  StepFacts of_free = facts;
  of_free.work = facts.free_work;
  StepPlan free = plan(settings, traits.of_free_islands(), of_free);
  free.islands = Islands::free;
  return free;
}

double tolerance_of_contacts(const SceneTraits& traits) { return automatic_tolerance_of(traits, automatic_tolerance); }

double least_creep(const SceneTraits& traits) {
  constexpr double tolerances = 1.5, share_of_fall = 1e-3;  // of g h^2: in short frames the solve leaves less than its tolerance
  const double least = tolerances * tolerance_of_contacts(traits), fall = traits.gravity * traits.step * traits.step;
  return fall > 0 ? std::min(least, share_of_fall * fall) : least;
}

bool links_are_tight(double geometric_stiffness) { return !(automatic_share * geometric_stiffness <= tight_links); }

}  // namespace unibody
