// Islands: bodies that act on one another, through contacts or constraints. What does not move joins none.
#pragma once

#include <cstdint>
#include <vector>

#include "solve/solver.hpp"
#include "step/rank_state.hpp"

namespace unibody {

// By slot, 1 where the body's island has a link, an element, a joint, an attachment or a contact of a surface, else 0. The same
// on any number of ranks. Collective. After assemble().
std::vector<std::int32_t> constrained_islands(const RankState& state, const System& system);

}  // namespace unibody
