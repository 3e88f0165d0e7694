// The coarse level of a step: Newton's method (coarse/primal_dual.hpp) on cloths, threads and solids, before the sweeps of the
// position stage, which go on from its velocities and multipliers.
//
// It knows of no contacts, joints or attachments. A cloth, thread or solid that has one in a step takes no part in that step, and
// is solved by sweeps alone, as without a coarse level. So is one whose energy would grow in the step, as far as Newton's method
// has come: what is left undone may not give energy.
#pragma once

#include <memory>
#include <vector>

#include "coarse/aggregates.hpp"
#include "scene/scene.hpp"
#include "step/step_report.hpp"

namespace unibody {

class PrimalDual;
struct RankState;
struct SolverBody;
struct StepPlan;
struct System;

struct CoarseLevel {
  // Of all cloths, threads and solids of a scene that asks for a coarse level; of none otherwise.
  explicit CoarseLevel(const Scene& scene);

  Aggregates aggregates;
  std::shared_ptr<PrimalDual> solver;  // lasts until slots move
  std::int64_t built_version = -1;     // of the halo, when the solver was laid out
  std::vector<std::int32_t> taken;     // in this step, of each slot: what it is a part of, where that was solved so; else -1

  bool exists() const { return aggregates.count() > 0; }
  std::size_t bytes() const;
};

struct CoarseSolve {
  double off = 0;  // m, what the momenta of what it solved are off by (PartReport)
  CoarseCounts counts;
};

// Sets the velocities and multipliers of the cloths, threads and solids that take part. `predicted`: the bodies before any warm
// start. Collective.
CoarseSolve solve_coarse_level(RankState& state, System& system, const StepPlan& plan, const std::vector<SolverBody>& predicted);

// Of what was solved so in this step nothing is remembered: its multipliers balance its velocities, and would push bodies far off
// from any others, as those are from which sweeps start. Newton's method starts from nothing anyway.
void forget_multipliers(RankState& state);

}  // namespace unibody
