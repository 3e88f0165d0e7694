// Bodies that attract each other where they touch: by a force of their pair of materials, and by their surface energy.
//
// A pair is pressed together, along its contact's normal, by the force F that would pull it apart, as long as the gap is within a
// range. The contact's impulse is at least 0 and its friction is bounded by that impulse, so that what a user sees, the contact's
// force less F, is at least -F, and the cone of friction has its tip at -F. The force is known before the step is solved, so that
// rows, solvers and residuals know nothing of it.
#pragma once

#include <vector>

#include "step/rank_state.hpp"

namespace unibody {

// N s, by contact point: what presses its two bodies together in the step. Bodies share their force equally among their points
// within the range. Empty where the scene's materials do not adhere. To be asked when contacts have been found: impacts change
// their gaps.
std::vector<double> adhesive_impulses(const RankState& state);

// Changes the predicted velocities of home bodies by StepRows::adhesive. The same bits on any number of ranks.
void attract(const RankState& state, System& system);

}  // namespace unibody
