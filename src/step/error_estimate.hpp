// How far a step is from the converged one: solves on from where its solve ended, or the same step anew, measures, and puts
// everything back.
#pragma once

#include "step/plan.hpp"
#include "step/rank_state.hpp"
#include "step/step_error.hpp"
#include "step/step_report.hpp"

namespace unibody {

// After the step's solve and what follows on it, before the bodies move. Leaves the state and the system as they are, but for the
// multipliers of the batches. Collective.
StepError estimate_error(RankState& state, System& system, const StepPlan& plan, const StepFacts& facts,
                         const SolvedStep& solved);

// m, the distance to the converged step as a short solve tells, from where the step ended: to a tenth of its natural residual, or
// as far as 8 times its iterations lead. What is left then is taken to be in proportion to the residual. Collective; leaves
// everything as estimate_error() does.
double sample_error(RankState& state, System& system, const StepPlan& plan, const StepFacts& facts, const SolvedStep& solved,
                    const StepReport& step);

}  // namespace unibody
