// Contacts are sought as far as bodies get at the speeds with which they start the step. A body that is struck within it gets
// further, and would run over what lies in its way: small bodies that a large one falls on, say. Such a step is taken once more,
// with contacts sought for the speed that was found, of that body and of all that it may set moving in turn.
#pragma once

#include "step/rank_state.hpp"

namespace unibody {

inline constexpr int most_searches = 3;  // how often contacts are sought anew in a step

// Whether the solve has given some body more speed than its contacts were sought for, and it meets on its way something that it
// has no contact with, by more than a tenth of the smaller one's half size. Those bodies are then added to
// search.settings.struck, the same list on all ranks. Collective.
bool find_struck(RankState& state, const System& system);

}  // namespace unibody
