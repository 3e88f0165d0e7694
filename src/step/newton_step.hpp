// A step by Newton's method, of one flexible body alone on one rank, as read_scene() and run() see to.
#pragma once

#include "step/plan.hpp"
#include "step/rank_state.hpp"
#include "step/step_report.hpp"

namespace unibody {

// The rows hold to round-off by construction where the impulses are eliminated: what says how far off the step is, is how far the
// next iteration would move the nodes.
StepReport newton_step(RankState& state, System& system, const StepPlan& plan);

}  // namespace unibody
