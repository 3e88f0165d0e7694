// Bounces of a step: impacts, one after the other as they happen, and what the solve's rows have to know of the others.
#pragma once

#include "step/rank_state.hpp"

namespace unibody {

// Resolves the impacts of free bodies (impacts.hpp), then sets, where anything may bounce, the velocities from which the contacts
// that are left to the solve's rows bounce, and the speeds at which they do. After Exchange::finish_step(). Collective.
void start_bounces(RankState& state, System& system);

}  // namespace unibody
