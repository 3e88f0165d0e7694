// Contact of two convex solids, for whoever has them by other ways than as bodies.
#pragma once

#include "collide/convex_distance.hpp"
#include "collide/narrowphase.hpp"

namespace unibody {

// Normal and points across it, none further apart than `margin` (m), at most PairManifold::capacity; positions as those of the
// two solids. False where there are none.
bool convex_manifold(const ConvexBody& a, const ConvexBody& b, double margin, PairManifold& out);

}  // namespace unibody
