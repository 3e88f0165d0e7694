// Where a body is touched once it has turned.
#pragma once

#include "core/types.hpp"
#include "world/world.hpp"

namespace unibody {

// The arm (m, world) from a body's centre to the point at which it is touched, after a turn: a corner turns along with its body,
// while a round surface rolls, and the point stays under the centre of its curvature. `arm`: before the turn, to a point of the
// body's surface there; `outwards`: the normal, away from the body.
Vec3 turned_arm(const World& world, Slot slot, const Vec3& arm, const Vec3& outwards, const Mat3& turn);

}  // namespace unibody
