// How much a joint bears, and which joints have broken.
#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "core/types.hpp"

namespace unibody {

// What breaks a joint, of the mean force and torque of its own rows over the last time `duration`, which is no shorter than five
// steps unless it is 0; infinite: nothing of that kind does. In single steps the forces of an iteration are off where it has not
// converged, or mends what the step before has left open. Their mean is right, since momentum is kept; and an impulse J counts as
// J / duration, however long a step is. The first two are of any direction. The others are about the joint's axis z on its first
// body, which points away from that body, and add up as the stresses in a round beam do: tension with bending, shear with
// twisting (Potyondy and Cundall 2004, eq. 15 and 16).
struct Strength {
  static constexpr double infinity = std::numeric_limits<double>::infinity();
  static constexpr double usual_duration = 0.02, least_steps = 5;
  double duration = usual_duration;            // s, the time constant of the mean, in which the past counts as exp(-t / duration)
  double force = infinity, torque = infinity;  // N, N m
  double tension = infinity, shear = infinity;     // N, along the axis and across it; pressure relieves what bending pulls
  double bending = infinity, twisting = infinity;  // N m, across the axis and about it

  bool any() const {
    return force < infinity || torque < infinity || tension < infinity || shear < infinity || bending < infinity ||
           twisting < infinity;
  }
};

// The largest share of its strength that a joint bears: it breaks above 1. force, torque (N, N m): on the first body, about the
// anchor, in axes whose z is the joint's.
double load_share(const Strength& strength, const Vec3& force, const Vec3& torque);

// A joint that has broken, or that an event has released: it does nothing from the step after that one on.
struct Break {
  std::int64_t joint = 0;  // its place in Scene::joints
  double time = 0;         // s, the end of the step in which it broke
  double force = 0;        // N, the mean that it bore; 0: it was released
  double torque = 0;       // N m
};

}  // namespace unibody
