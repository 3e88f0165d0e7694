// Impacts, one after the other as they happen within the step.
//
// A solver that gives two bodies the speed at which they part for the whole of the step sends them off from where they were at
// its start, and takes all speed from whatever they meet next. So impacts of bodies that are free, with each other and with what
// does not move, are found along the predicted motion before the solve, in the order of their times, and change the prediction:
// each by the impulses of its pair alone (Newton's hypothesis, Coulomb friction), at the place and with the arms of its moment. A
// body that is hit at t goes on as if it had started the step elsewhere (seeming_starts.hpp). Momentum, angular momentum and,
// without friction and with a restitution of 1, energy are kept to rounding.
//
// Which impacts are: those faster than 2 g h with a restitution, and those of round bodies that move past what they hit by more
// than half a size in the step, with any. Bodies with joints, nodes and what is attached are not free; contacts of those bounce
// in the solve, and so do those of other solids that are swept.
#pragma once

#include "step/rank_state.hpp"

namespace unibody {

// Changes what is predicted of bodies that are hit, and the gaps and bounces of contacts, and fills state.impacts. After
// Exchange::finish_step(). Collective. Returns how many impacts this rank counts: over all ranks, each once.
std::int64_t resolve_impacts(RankState& state, System& system);

}  // namespace unibody
