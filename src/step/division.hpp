// A joint is solved as if its bodies moved along straight lines within a step. A step in which a jointed body turns too far for
// that is divided: it is taken as several shorter steps of equal length.
#pragma once

#include "step/rank_state.hpp"

namespace unibody {

inline constexpr int most_parts = 64;

// Into how many parts the next step is divided: as many as keep every turn that opens or tilts a joint below most_turn_of_rows
// (joint rows follow their curve up to there). One where nothing turns fast. Collective.
int parts_of_step(const RankState& state);

// Makes `step` (s) the length of the steps to come: the histories that hold impulses are scaled by the ratio of lengths.
void set_step_length(RankState& state, double step);

}  // namespace unibody
