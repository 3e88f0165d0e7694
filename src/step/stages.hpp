// The solve of a step: its warm start, its stages, and what is measured of its solution.
#pragma once

#include "step/plan.hpp"
#include "step/rank_state.hpp"
#include "step/step_report.hpp"

namespace unibody {

// Starts the batches from the last step's multipliers, by the shares of the plan, and adds their impulses to the bodies.
// Collective.
void warm_start(RankState& state, System& system, const StepPlan& plan);

// Runs the solver for one stage. It starts from the batches' multipliers; their impulses must already be part of the bodies'
// velocities. Collective.
SolveReport run_stage(RankState& state, System& system, const StepPlan& plan, const StepFacts& facts, Stage::Kind kind,
                      SolveFunction solver, int iterations, const StopRule& rule);

// The natural residuals of the stage that was run last, over all ranks, in one message. `left`: of an earlier stage on this rank
// (m), which counts too: the position stage starts anew, and would hide it. Collective.
void measure_solution(const RankState& state, const System& system, const StepPlan& plan, StepReport& report, double left = 0);

// Two stages: velocities first, from the full multipliers of the last step, with existing penetration left alone; then positions.
// A share of what the second had to add leaks into what the first starts from next time, unless the first has converged: a leak
// then feeds on what the tolerance leaves, and what lies still trembles within it. Or positions alone, from a share of the
// old multipliers that must stay below 1/2: an unconverged position stage that starts from more gains energy.
// Constraints other than contacts, attachments too, belong to the position stage; where there are no contacts, it is the only
// one. At velocity level there is one stage too, of all constraints; what it leaves of the old multipliers does no harm there
// up to a larger share (solver_settings.hpp). Collective.
StepReport solve(RankState& state, System& system, const StepPlan& plan, const StepFacts& facts, const StepRequest& request);

}  // namespace unibody
