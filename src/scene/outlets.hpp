// The section `outlets`.
#pragma once

#include <utility>

#include "scene/key.hpp"
#include "scene/scene.hpp"

namespace unibody {

// {low, high}: the corners of a box (m), the second above the first along each axis; along y, too, they may be equal in a planar
// scene.
std::pair<Vec3, Vec3> read_corners(const Value& box, bool planar = false);

// Reads the list `outlets` into scene.outlets. Bodies and materials are read before.
void read_outlets(const Value& list, Scene& scene);

const Keys& outlet_keys();
const Keys& corners_keys();  // of a box

}  // namespace unibody
