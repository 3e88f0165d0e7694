// Corners that a turning body brings into contact within the step.
#pragma once

#include "collide/narrowphase.hpp"

namespace unibody {

// The manifold of two solids holds the corners of what they turn to each other at the step's start: of a hull one face or edge,
// of a cylinder a side or a cap. Of one that turns it is another corner that comes down on the other solid. Adds to a manifold
// of two simple shapes where they are, whose normal leads from the second to the first, what will be foremost half way through
// the step and at its end, and where the contact turns the body aside: each where that lies over a flat side of the other and is
// no further from it than `margin` (m). Positions from the first body's centre.
void add_corners_ahead(const Proxy& first, const Proxy& second, double step, double margin, PairManifold& manifold);

}  // namespace unibody
