// Creep of bodies that stick. What a step leaves undone of friction is a small slip, always in the same direction, that adds up
// from step to step: a cube between two fingers slides out of them, however far friction is from its limit. So the slip of
// contacts that stick is summed, and each step is asked to take a part of that sum back: where it leaves as much undone as it is
// asked to take back, nothing moves any more. (In control engineering: an integral part.)
//
// The slip is of two kinds: along the faces, and a turn about their normal. A contact that slides forgets them within some steps,
// since one that sticks may seem to slide in a step that is far from solved; one that opens forgets them at once. The velocities
// at which the tangents of a contact aim are less by what is to be taken back, as they are by the drift of what is carried along
// a circle (carried.hpp).
//
// In piles of bodies alone, solved in two stages, whether there are other things in the scene or not, contacts of faces have this
// memory, by which towers stand; contacts of a point or an edge, at which bodies roll, have none, since it kept piles of balls
// from coming to rest.
//
// What a contact has crept by is taken back only as far as it is more than about the tolerance of the solve. What is less may be
// the noise of the solve as well, of which contacts that hold the same bodies remember different parts: taken back, it kept walls
// of bricks from coming to rest.
//
// The share that is taken back is a fourth of what made a table of convex pieces rock with accelerated Jacobi.
#pragma once

#include <cstdint>

#include "constraints/multipliers.hpp"

namespace unibody {

inline constexpr double creep_taken_out = 0.1;             // share of the creep that a step takes back
inline constexpr double most_creep = 0.01;                 // of the smaller body's bounding radius, and in rad: more is forgotten
inline constexpr double creep_kept = 0.9;                  // share of the creep that a step leaves to a contact that slides
inline constexpr double sticking = 0.98;                   // share of friction's limit, up to which a contact sticks
inline constexpr std::uint32_t least_points_in_piles = 3;  // of a manifold

// What of a creep a step is to take back, before its share: what is beyond the least (m), which of a turn is seen at `reach` (m).
inline Creep beyond(const Creep& creep, double least, double reach) {
  const auto rest = [](double size, double small) { return size > small ? 1 - small / size : 0.0; };
  return {creep.slip * rest(creep.slip.norm(), least), creep.turn * rest(reach * creep.turn.norm(), least)};
}

}  // namespace unibody
