// A step is divided, that is, taken as several shorter steps of equal length, for two reasons. A joint is solved as if its bodies
// moved along straight lines within a step, which a body that turns fast does not. And contacts are found at the start of a step,
// and are linear within it: boxes that tumble reach places in it that no contact knew of. How deep they are then is seen at the
// start of the next step, which a run with an accuracy divides into twice as many parts where that is more than it allows.
#pragma once

#include "step/rank_state.hpp"

namespace unibody {

inline constexpr int most_parts = 64;

// Into how many parts the next step is divided: as many as keep every turn that opens or tilts a joint below most_turn_of_rows
// (joint rows follow their curve up to there), and no fewer than the state's fineness. One where nothing turns fast. Collective.
int parts_of_step(const RankState& state);

// The fineness of the step that is taken next, of one whose deepest contact (m) goes so far in, with that much allowed (m).
Fineness next_fineness(Fineness before, double deepest, double allowed);

// Renews the state's fineness, where the scene asks for an accuracy. After detect(). Collective.
void renew_fineness(RankState& state);

// Makes `step` (s) the length of the steps to come: the histories that hold impulses are scaled by the ratio of lengths.
void set_step_length(RankState& state, double step);

}  // namespace unibody
