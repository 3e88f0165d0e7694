// Whether two solids that are apart will touch in the step or pass each other by, and where they are nearest to each other then.
//
// The rows of a contact hold one solid behind a plane across the distance of the two. Where that plane stands as the two are at
// the start of the step, what passes by an edge or a round side runs into it beside the solid, and is turned aside by what it
// never touches. For what passes by, the plane has to stand across the distance of the two at the time when they are nearest
// to each other. Both planes separate: two solids that end the step on the two sides of either of them do not overlap.
#pragma once

#include <algorithm>

#include "core/types.hpp"

namespace unibody {

// Two convex solids at a time of the step.
struct Separation {
  double gap;      // m, of the two nearest points; positive: the solids are apart
  double closing;  // m/s, at which these approach each other
};

// Of two solids that move less than this share of the smaller half size against each other in the step, the direction from one
// to the other does not turn enough to matter.
constexpr double least_approach = 0.01;

struct Encounter {
  double time = 0;       // s
  bool touches = false;  // then; else they pass each other by
  bool passes() const { return time > 0 && !touches; }
};

// When in the step two convex solids that move along lines first touch, or where they never do, are nearest to each other and no
// longer approach: at most `step`. 0: as they stand, since they touch, or part, or would not come to touch at the speed at which
// they close now, or cannot be told. `separation_at(time, separation)` returns false where it cannot tell.
//
// The distance of two such solids is a convex function of time: Newton's method comes to the first root from before it and never
// oversteps it, and between a time at which they approach and one at which they part lies the least. Of faces that stretch this
// holds nearly; what is found is a time of the step in any case.
template <class SeparationAt>
Encounter encounter_of(double step, double close, SeparationAt&& separation_at) {
  constexpr int most_steps = 32, bisections = 10;
  Separation now, then;
  if (!separation_at(0, now)) return {};
  if (!(now.gap > close && now.gap < step * now.closing)) return {};
  double time = 0;
  for (int i = 0; i < most_steps && now.gap > close && time < step; ++i) {
    const double next = std::min(step, time + now.gap / now.closing);
    if (!separation_at(next, then)) return {time, false};
    if (then.gap > close && !(then.closing > 0)) {
      double nearing = time, parting = next;
      for (int k = 0; k < bisections; ++k) {
        const double middle = 0.5 * (nearing + parting);
        if (!separation_at(middle, then)) break;
        if (then.gap <= close) return {middle, true};
        (then.closing > 0 ? nearing : parting) = middle;
      }
      return {parting, false};
    }
    time = next, now = then;
  }
  return {time, now.gap <= close};
}

}  // namespace unibody
