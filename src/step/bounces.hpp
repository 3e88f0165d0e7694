// The bounces of a step. Impacts of free bodies are resolved one after the other, as they happen in the step; every other bounce
// is a row of the solve, which is told here from which velocities it starts.
#pragma once

#include "step/rank_state.hpp"

namespace unibody {

// Resolves the impacts of free bodies (impacts.hpp), then sets, where anything may bounce, the velocities from which the contacts
// that are left to the solve's rows bounce, and the speeds at which they do. After Exchange::finish_step(). Collective.
void start_bounces(RankState& state, System& system);

}  // namespace unibody
