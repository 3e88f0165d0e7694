// When bodies that move along parabolas first touch: within a step of length `step` (s) a place goes as
// x(t) = x + t v + t (t - step) a / 2, so that v is the mean velocity of the step and a the acceleration.
#pragma once

#include <limits>

#include "core/types.hpp"

namespace unibody {

inline constexpr double never = std::numeric_limits<double>::infinity();

// The first time t (s) in [from, to] at which two spheres are as near as the sum of their radii, `reach` (m), and approach each
// other; `apart` (m), `velocity` (m/s) and `acceleration` (m/s^2) are of the first relative to the second.
double first_touch_of_spheres(const Vec3& apart, const Vec3& velocity, const Vec3& acceleration, double step, double reach,
                              double from, double to);

// The first time at which a point reaches a plane that it approaches. `gap` is their distance (m) at the start; velocity and
// acceleration are the point's relative to the plane, along its normal, which points to the point.
double first_touch_of_plane(double gap, double velocity, double acceleration, double step, double from, double to);

}  // namespace unibody
