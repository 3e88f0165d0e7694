// Cores: the ball about a solid's centre, of which turning within the step moves nothing.
//
// Where a fast body first touches with one end, the impact turns it, and its centre and its other end go on: no sweep and no
// margin foresees that. The core is swept for itself, and what it would get into is one contact more: the centre stays before it
// however the body turns. Bodies have one where they move further in the step than 1.5 times their smallest size, or turning
// carries their surface half of that; what is slower keeps its centre by the contacts that it has anyway. Its radius is a quarter
// of the body's smallest size, so that it is a part of the solid: no side of a convex solid is nearer to its centroid than a
// quarter of the width across it.
//
// What lies across a thin wall after the step is pushed out the shorter way, which must be the side of the centre. Of a body that
// reaches further ahead of its centre than behind it, the core therefore stays away by half the difference.
#pragma once

#include "collide/narrowphase.hpp"

namespace unibody {

constexpr std::uint32_t core_feature = 0xffffffff;  // of a core's contact point; its manifold follows that of the pair as a whole

// Whether the path of a's centre in the step, straight at the present velocities, goes into b, which is not a mesh; b's turning
// left aside.
bool centre_meets(const Proxy& a, const Proxy& b, double step);

}  // namespace unibody
