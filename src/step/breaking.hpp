// Joints that break, and what a rank knows of those that have. A joint that has broken stays in all lists, and no batch has rows
// for it.
#pragma once

#include <span>

#include "step/rank_state.hpp"

namespace unibody {

// Marks the joints that the history says have broken, takes their impulses away and lets their bodies be free, unless something
// else ties them. To be called before contacts are found. A call that finds nothing new does nothing.
void know_breaks(RankState& state);

// Adds to the history the joints that bore more than they can in the last step (Joint::bears), with the present time. Guests are
// where the step took them. The function is collective, and does nothing in a scene where no joint breaks.
void break_overloaded(RankState& state);

// Adds joints to the history that do nothing from now on; some may have broken before.
void release_joints(RankState& state, std::span<const std::size_t> joints);

}  // namespace unibody
