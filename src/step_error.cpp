// How far a step is from the converged one: solves on from where its solve ended, measures, and puts everything back.

#include <limits>

#include "core/exact_sum.hpp"
#include "solve/friction_postprocess.hpp"
#include "solve/surface_guard.hpp"
#include "step.hpp"

namespace unibody {

namespace {

// The reference takes rounds of iterations, each twice as long as the one before, so that momentum may grow. It ends when the
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

// The rows of the position stage, on the multipliers of both stages together (Stages::joint): what a step with any number of
// iterations is after. What follows on a solve, the guard of surfaces and friction after the solve, the converged step has too.
StepError Simulation::estimate_error(const SolvedStep& solved) {
  const PhaseClock::Scope scope(clock_, Phase::other);  // no part of the step's own time
  const std::vector<SolverBody> taken(system_.bodies.begin(), system_.bodies.end());
  const std::vector<SolverBody> taken_moving(system_.moving.begin(), system_.moving.end());
  const std::vector<Vec3> velocity_after = world.velocity;
  const auto restore = [](auto& to, const auto& from) { to.assign(from.begin(), from.end()); };

  restore(system_.bodies, solved.solved);
  system_.moving.clear();
  system_.contacts.set_impulses(solved.impulses);
  system_.surface.join_stages();
  system_.rolling.join_stages();
  StepError error;
  std::vector<SolverBody> best = solved.solved;
  std::vector<ContactBatch::Impulse> impulses = solved.impulses;
  error.reference_residual = std::numeric_limits<double>::infinity();
  const SolveFunction solver = solver_.sweeps_by_colour ? solver_.solve : accelerated_jacobi;  // same layout, converges faster
  int length = std::max(first_round, scene_.solver.iterations);
  for (int round = 0, idle = 0; round < most_rounds && (round < least_rounds || idle < idle_rounds) &&
                                error.reference_residual > share_of_tolerance * tolerance_;
       ++round, length *= 2) {
    error.iterations += run_stage(Stage::Kind::position, solver, length, 0).iterations;
    StepReport now;
    measure_solution(now);
    idle = now.residual <= 0.5 * error.reference_residual ? 0 : idle + 1;
    if (!(now.residual < error.reference_residual)) continue;
    error.reference_residual = now.residual;
    restore(best, system_.bodies);
    system_.contacts.get_impulses(impulses);
  }
  restore(system_.bodies, best);
  std::copy(solved.velocity_before.begin(), solved.velocity_before.end(), world.velocity.begin());
  if (has_surfaces()) SurfaceGuard(world, surfaces_, collide_settings_, &scratch_).hold(system_.bodies, halo_);
  if (scene_.solver.friction == FrictionModel::postprocess) {
    system_.contacts.set_impulses(impulses);
    postprocess_friction(world, contacts, std::vector<ContactBatch::Impulse>(contacts.points.size()), system_, cut_);
  }

  const auto& converged = system_.moving.empty() ? system_.bodies : system_.moving;
  const auto& moving = taken_moving.empty() ? taken : taken_moving;
  std::array<ExactSum, 3> sums;
  for (std::size_t i = 0; i < world.homes; ++i) {
    if (taken[i].inverse_mass == 0) continue;
    sums[0] += twice_energy(world, i, moving[i], converged[i]);
    sums[1] += twice_energy(world, i, solved.predicted[i], converged[i]);
    sums[2] += world.properties[i].mass;
  }
  const auto total = all_sums(halo_.comm(), sums);
  if (total[2] > 0) error.distance = step_ * std::sqrt(total[0] / total[2]);
  if (total[1] > 0) error.relative = std::sqrt(total[0] / total[1]);

  restore(system_.bodies, taken);
  restore(system_.moving, taken_moving);
  std::copy(velocity_after.begin(), velocity_after.end(), world.velocity.begin());  // in place: the Vec lies over it
  return error;
}

}  // namespace unibody
