// The shortest turn from one direction to another. It is compiled once, since Eigen's takes seconds in each source.
#pragma once

#include "core/types.hpp"

namespace unibody {

Quat shortest_turn(const Vec3& from, const Vec3& to);

}  // namespace unibody
