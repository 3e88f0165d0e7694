// Creep of bodies that stick. What a step leaves undone of friction is a small slip, always in the same direction, that adds up
// from step to step: a cube between two fingers slides out of them, however far friction is from its limit. So the slip of
// contacts that stick is summed, and each step is asked to take a part of that sum back: where it leaves as much undone as it is
// asked to take back, nothing moves any more. (In control engineering: an integral part.)
//
// A contact that slides, or opens, forgets its creep. The velocities at which the tangents of a contact aim are less by what is
// to be taken back, as they are by the drift of what is carried along a circle (carried.hpp).
#pragma once

namespace unibody {

inline constexpr double creep_taken_out = 0.2;  // share of the creep that a step takes back
inline constexpr double most_creep = 0.01;      // of the smaller body's bounding radius: more is forgotten
inline constexpr double sticking = 0.98;        // share of friction's limit, up to which a contact sticks

}  // namespace unibody
