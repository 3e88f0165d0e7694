// How far a step is from the converged one: solves on from where its solve ended, or the same step anew, measures, and puts
// everything back.

#include <algorithm>
#include <limits>

#include "build.hpp"
#include "core/exact_sum.hpp"
#include "joints/joint_set.hpp"
#include "solve/friction_postprocess.hpp"
#include "solve/recall.hpp"
#include "solve/surface_guard.hpp"
#include "step.hpp"

namespace unibody {

namespace {

// A reference takes rounds of iterations, each twice as long as the one before, so that momentum may grow. It ends when the
// natural residual is that share of the solver's tolerance, when two rounds one after the other have not halved it, not before
// the fifth, or after the last round.
constexpr int first_round = 100, least_rounds = 5, most_rounds = 8, idle_rounds = 2;
constexpr double share_of_tolerance = 1e-6;

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

}  // namespace

// Of all stages that the step had.
std::vector<ContactBatch::Impulse> Simulation::total_impulses(std::span<const ContactBatch::Impulse> kept, bool apart) const {
  std::vector<ContactBatch::Impulse> total(contacts.points.size());
  system_.contacts.get_impulses(total);
  for (std::size_t k = 0; k < total.size() && apart; ++k)
    total[k].n += kept[k].n, total[k].s += kept[k].s, total[k].t += kept[k].t;
  return total;
}

// Solves the rows of the position stage, on the multipliers of both stages together (Stages::joint): what a step with any number
// of iterations is after. What follows on a solve, the guard of surfaces and friction after the solve, the converged step has
// too. Starts from the system as it is.
ConvergedStep Simulation::converge(SolveFunction solver) {
  ConvergedStep converged;
  std::vector<SolverBody> best(system_.bodies.begin(), system_.bodies.end());
  std::vector<ContactBatch::Impulse> impulses(contacts.points.size());
  system_.contacts.get_impulses(impulses);
  int length = std::max(first_round, scene_.solver.iterations);
  for (int round = 0, idle = 0; round < most_rounds && (round < least_rounds || idle < idle_rounds) &&
                                converged.residual > share_of_tolerance * tolerance_;
       ++round, length *= 2) {
    converged.iterations += run_stage(Stage::Kind::position, solver, length, 0).iterations;
    StepReport now;
    measure_solution(now);
    idle = now.residual <= 0.5 * converged.residual ? 0 : idle + 1;
    if (!(now.residual < converged.residual)) continue;
    converged.residual = now.residual;
    best.assign(system_.bodies.begin(), system_.bodies.end());
    system_.contacts.get_impulses(impulses);
  }
  system_.bodies.assign(best.begin(), best.end());
  if (has_surfaces()) SurfaceGuard(world, surfaces_, collide_settings_, &scratch_).hold(system_.bodies, halo_);
  if (scene_.solver.friction == FrictionModel::postprocess) {
    system_.contacts.set_impulses(impulses);
    postprocess_friction(world, contacts, std::vector<ContactBatch::Impulse>(contacts.points.size()), system_, cut_);
  }
  const auto& moving = system_.moving.empty() ? system_.bodies : system_.moving;
  converged.moving.assign(moving.begin(), moving.begin() + static_cast<std::ptrdiff_t>(world.homes));
  return converged;
}

// From where the step's own iterations ended, with its own layout of the constraints.
ConvergedStep Simulation::solve_on(const SolvedStep& solved) {
  const std::vector<SolverBody> taken(system_.bodies.begin(), system_.bodies.end());
  const std::vector<SolverBody> taken_moving(system_.moving.begin(), system_.moving.end());
  const std::vector<Vec3> velocity_after = world.velocity;
  system_.bodies.assign(solved.solved.begin(), solved.solved.end());
  system_.moving.clear();
  system_.contacts.set_impulses(solved.impulses);
  system_.surface.join_stages();
  system_.rolling.join_stages();
  std::copy(solved.velocity_before.begin(), solved.velocity_before.end(), world.velocity.begin());
  const ConvergedStep converged =
      converge(solver_.sweeps_by_colour ? solver_.solve : accelerated_jacobi);  // same layout, converges faster
  system_.bodies.assign(taken.begin(), taken.end());
  system_.moving.assign(taken_moving.begin(), taken_moving.end());
  std::copy(velocity_after.begin(), velocity_after.end(),
            world.velocity.begin());  // in place: the Vec lies over it
  return converged;
}

// The solver that converges where others take for ever: a chain of n links takes local ones some n^2 iterations.
Scene Simulation::scene_of_reference() const {
  Scene scene = scene_;
  scene.solver.name = "accelerated_jacobi";
  scene.solver.order = Order::coloured;
  scene.solver.joints = JointSolve::direct;
  scene.solver.warm_start = 1;
  scene.solver.scaling = 1;
  scene.joint_trees = plant_trees(scene.joints, [&](Id id) {
    const Slot slot = world.find(id);  // what does not move is on every rank
    return slot >= 0 && world.is_static(slot);
  });
  return scene;
}

// Whether that solver would do anything else than solve_on(). Where constraints have the incremental form, what they converge to
// depends on the way: there is no other one to it.
bool Simulation::has_other_reference() const {
  const bool any_way = constraints_of_all_ == 0 || form_ == Form::total || at_velocity_level();
  return any_way && (solver_.sweeps_by_colour || has_iterative_joints());
}

// The same step in a simulation of its own, from the multipliers that the step ended with.
ConvergedStep Simulation::solve_anew(const SolvedStep& solved) const {
  const Scene scene = scene_of_reference();
  PhaseClock clock;
  Simulation other(halo_.comm(), scene, clock, shares_memory_);
  std::vector<Body> homes, statics;
  for (std::size_t i = 0; i < world.size(); ++i) {
    if (!world.is_home(static_cast<Slot>(i)) && !world.is_static(static_cast<Slot>(i))) continue;
    Body body = world.body(i);
    body.state.velocity = solved.velocity_before[i];
    (i < world.homes ? homes : statics).push_back(body);
  }
  other.world = make_world(homes, statics, world.has_rotations);
  other.steps_done = steps_done, other.tolerance_ = tolerance_;
  other.collide_settings_.margin = collide_settings_.margin, other.recovery_speed_ = recovery_speed_;
  remember(other.multipliers, world, contacts, solved.impulses, step_);
  other.make_constraints();
  other.constraint_multipliers = constraint_multipliers;
  for (std::size_t k = 0; k < other.joints.size(); ++k) {  // more than here: whole trees
    const auto here = std::lower_bound(joints.begin(), joints.end(), other.joints[k]);
    if (here != joints.end() && *here == other.joints[k])
      other.joint_impulses[k] = joint_impulses[static_cast<std::size_t>(here - joints.begin())];
  }
  other.detect();
  other.turning_.assign(other.world.size() + 1, 0.0);
  if (!turning_.empty()) std::copy_n(turning_.begin(), world.homes, other.turning_.begin());
  ConvergedStep converged;
  other.steadily([&] {
    other.build_system();
    other.warm_start(1);
    converged = other.converge(accelerated_jacobi);
    other.joint_batch_.get_impulses(other.joint_impulses);
  });
  return converged;
}

ConvergedStep Simulation::converged_step(const SolvedStep& solved) {
  const double solved_to = share_of_tolerance * tolerance_;
  ConvergedStep best;
  const auto take = [&](ConvergedStep found) {
    const int iterations = best.iterations + found.iterations;
    if (!(best.residual <= found.residual)) best = std::move(found);
    best.iterations = iterations;
  };
  const bool other = has_other_reference();
  if (other && has_iterative_joints()) take(solve_anew(solved));
  if (!(best.residual <= solved_to)) take(solve_on(solved));
  if (other && !has_iterative_joints() && !(best.residual <= solved_to)) take(solve_anew(solved));
  return best;
}

StepError Simulation::estimate_error(const SolvedStep& solved) {
  const PhaseClock::Scope scope(clock_,
                                Phase::other);  // no part of the step's own time
  const ConvergedStep converged = converged_step(solved);
  const auto& moving = system_.moving.empty() ? system_.bodies : system_.moving;
  std::array<ExactSum, 3> sums;
  for (std::size_t i = 0; i < world.homes; ++i) {
    if (system_.bodies[i].inverse_mass == 0) continue;
    sums[0] += twice_energy(world, i, moving[i], converged.moving[i]);
    sums[1] += twice_energy(world, i, solved.predicted[i], converged.moving[i]);
    sums[2] += world.properties[i].mass;
  }
  StepError error;
  error.reference_residual = converged.residual, error.iterations = converged.iterations;
  const auto total = all_sums(halo_.comm(), sums);
  if (total[2] > 0) error.distance = step_ * std::sqrt(total[0] / total[2]);
  if (total[1] > 0) error.relative = std::sqrt(total[0] / total[1]);
  return error;
}

}  // namespace unibody
