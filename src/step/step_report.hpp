// What a step is asked for, and what it tells of itself.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "solve/batches.hpp"
#include "solve/surface_guard.hpp"
#include "step/contact_impulse.hpp"
#include "step/plan.hpp"
#include "step/step_error.hpp"
#include "step/worst_constraint.hpp"

namespace unibody {

struct ContactProblem;

// What a step is asked for beside itself. None of it changes what the step does. Collective: the same on every rank.
struct StepRequest {
  bool error = false;                 // StepReport::error; iterative solvers only
  ContactProblem* problem = nullptr;  // filled in, on rank 0, with the frictional contact problem of the rigid bodies
  double name_above = std::numeric_limits<double>::infinity();  // m: StepReport::worst, where the residual is larger
  bool impulses = false;                                        // StepReport::impulses
  bool may_be_outrun = false;  // the step may end with StepReport::outrun, nothing but the velocities having changed
};

// What the coarse level did with the cloths, threads and solids of a scene that asks for it, each counted once a step.
struct CoarseCounts {
  std::int64_t solved = 0, touching = 0, gaining = 0;  // by it; by sweeps, in contact or attached; or as their energy would grow

  void add(const CoarseCounts& other) { solved += other.solved, touching += other.touching, gaining += other.gaining; }
  std::int64_t all() const { return solved + touching + gaining; }
};

struct StepReport {
  int iterations = 0;
  double residual = 0;         // m, natural residual, of two stages the larger; max over ranks
  double estimated_error = 0;  // m, where the scene asks for an accuracy; see accuracy.hpp
  double turning = 0;          // m, what constraints between centres miss because they turn (turning.hpp); max over ranks
  bool converged = false;      // the residual is within the tolerance, and so is the turning
  std::array<double, BatchTypes::size> batch_residuals{};  // m, of each batch by itself, of the last stage
  SurfaceGuard::Held guard;      // pairs that would have passed through each other, had they not been held
  std::int64_t held_bodies = 0;  // that would have passed through what does not move by forces (side_guard.hpp)
  bool outrun = false;           // some body was set moving faster than its contacts were sought for (struck.hpp): not to be kept
  bool form_left = false;        // taken in the incremental form, not the total one that the scene asks for
  CoarseCounts coarse;           // of the scene's cloths, threads and solids
  std::int64_t impacts = 0;      // that were resolved by themselves (impacts.hpp), over all ranks
  std::int64_t sliding = 0;      // contact points at the limit of friction, over all ranks
  std::vector<StepPlan> plans;   // by which it was taken: one, or one of each kind of islands
  std::vector<ContactImpulse> impulses;  // of contacts that this rank counts, where they were asked for
  std::optional<StepError> error;        // where it was asked for
  std::optional<WorstConstraint> worst;  // the one with the residual, where it was asked for

  // Adds what a further part of the step came to: sums, the worst of the errors, and the last part's state.
  void add_part(const StepReport& part, bool first) {
    if (first) {
      *this = part;
      return;
    }
    iterations += part.iterations, guard.pairs += part.guard.pairs, impacts += part.impacts;
    if (guard.not_held[0] < 0) guard.not_held = part.guard.not_held;
    held_bodies += part.held_bodies;
    estimated_error += part.estimated_error;
    turning = std::max(turning, part.turning);
    residual = std::max(residual, part.residual), converged = converged && part.converged;
    for (std::size_t k = 0; k < batch_residuals.size(); ++k)
      batch_residuals[k] = std::max(batch_residuals[k], part.batch_residuals[k]);
    coarse.add(part.coarse);
    form_left = form_left || part.form_left, sliding = part.sliding, error = part.error;
    plans = part.plans;
    impulses.insert(impulses.end(), part.impulses.begin(), part.impulses.end());
    if (part.worst && (!worst || part.worst->precedes(*worst))) worst = part.worst;
  }

  // The residual of each type of constraint between centres (m), in the order of their list.
  std::array<double, ConstraintTypes::size> constraint_residuals() const {
    std::array<double, ConstraintTypes::size> list{};
    for_each_batch_type([&]<class B>(auto place, std::type_identity<B>) {
      if constexpr (is_constraint_batch<B>) list[type_index<typename B::Type>] = batch_residuals[place];
    });
    return list;
  }
  template <class B>
  double residual_of() const {
    return batch_residuals[batch_place<B>];
  }
};

}  // namespace unibody
