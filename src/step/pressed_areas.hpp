// The areas on which motors press whose strength is a pressure.
#pragma once

#include "step/rank_state.hpp"

namespace unibody {

// Measures RankState::pressed_areas where the bodies are now, which every rank then knows. Collective. After
// build_lasting().
void measure_pressed_areas(RankState& state);

}  // namespace unibody
