// What a simulation's step evaluates, as the balance of its ranks counts it.
#pragma once

#include "partition/work.hpp"
#include "step/rank_state.hpp"

namespace unibody {

// Contacts are those of the last detect(); before it there are none.
inline StepParts parts_of(const RankState& state) {
  return {state.world, state.contacts, &state.ties.constraints, state.scene.joints, state.ties.joints};
}

}  // namespace unibody
