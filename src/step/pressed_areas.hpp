// The areas on which motors press whose strength is a pressure.
#pragma once

#include "step/rank_state.hpp"

namespace unibody {

// Measures Ties::pressed_areas by where the bodies are now; every rank then knows all of these areas. Collective. It comes
// after build_lasting(), which finds the slots of joints.
void measure_pressed_areas(RankState& state);

}  // namespace unibody
