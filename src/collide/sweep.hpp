// Swept tests, for bodies that move further in a step than half their size relative to each other.
//
// The motion between the two is taken as a straight line at the present velocities; turning within the step is ignored. Under
// that the tests are exact: a quadratic for spheres and discs, a convex root for a sphere and a box and for any two
// convex solids, and the 15 axes with their times of entry and exit for two boxes. They end where the motion is not foreseen: a
// body turned aside by a third one within the step may pass through what it was not heading for, and a fast spinning box may be
// missed by up to h r |w|.
#pragma once

#include "collide/narrowphase.hpp"

namespace unibody {

enum class Sweep : std::uint8_t { overlap, hit, miss };  // overlap: they touch before they start

struct Impact {
  double time = 0;  // s
  int axis = -1;    // BoxAxis::code for two boxes
};

// `velocity` is a's relative to b; hits later than `limit` (s) are misses.
using SweepFunction = Sweep (*)(const Proxy& a, const Proxy& b, const Vec3& velocity, double limit, Impact& impact);

Sweep sweep_round_round(const Proxy& a, const Proxy& b, const Vec3& velocity, double limit, Impact& impact);
Sweep sweep_round_box(const Proxy& a, const Proxy& b, const Vec3& velocity, double limit, Impact& impact);
Sweep sweep_box_box(const Proxy& a, const Proxy& b, const Vec3& velocity, double limit, Impact& impact);
Sweep sweep_convex(const Proxy& a, const Proxy& b, const Vec3& velocity, double limit, Impact& impact);  // any two convex solids

}  // namespace unibody
