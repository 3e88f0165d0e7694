// Where a body is touched once it has turned.
#pragma once

#include "core/types.hpp"
#include "world/world.hpp"

namespace unibody {

// The arm (m, world) from a body's centre to the point where it is touched once it has turned. A corner turns along with its
// body. A round surface rolls: the point where it is touched stays under its centre of curvature. `arm`: before the turn, to a
// point of the body's surface there; `outwards`: the normal, away from the body.
Vec3 turned_arm(const World& world, Slot slot, const Vec3& arm, const Vec3& outwards, const Mat3& turn);

}  // namespace unibody
