// Kinematic bodies whose velocities change in time.
#pragma once

#include "step/rank_state.hpp"

namespace unibody {

// Gives them the mean velocities of the step that is to be taken, on every rank: it then ends where the scene says that they are.
// Before contacts are sought for.
void set_prescribed_velocities(RankState& state);

}  // namespace unibody
