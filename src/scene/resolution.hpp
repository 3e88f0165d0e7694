// What doubles cannot resolve: sizes that are lost in the rounding of their places, speeds beyond all physics, steps in which
// rounding moves the bodies more than they move.
#pragma once

#include "scene/scene.hpp"

namespace unibody {

// Throws InputError on the first body of a size, place, speed or step that doubles do not resolve:
// - a size outside of 1e-15 to 1e15 m, or a place further than 1e15 m from the origin;
// - a size of less than 1e7 times the rounding of the body's coordinates;
// - a speed of 299,792,458 m/s or more, of its centre or, by turning, of its surface;
// - a step in which the rounding of a coordinate, as a speed, exceeds 1e-6 of the scene's speed: the largest of the speeds at the
//   start and of those that the bodies gain from rest on the way of their own size, by gravity or their forces; or one in which
//   gravity adds a speed whose rounding does.
// Of entries of more than 100,000 bodies, the first and last 1000 are looked at.
void check_resolution(const Scene& scene);

}  // namespace unibody
