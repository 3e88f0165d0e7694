// A triangle mesh as plain data: what files and generators give, and what cloth and rigid meshes are built from.
#pragma once

#include <array>

#include "core/types.hpp"

namespace unibody {

// Both nodes and triangles are numbered from 0.
struct TriangleMesh {
  std::vector<Vec3> nodes;                             // m
  std::vector<std::array<std::int32_t, 3>> triangles;  // nodes of each, counterclockwise as seen from the outside
};

}  // namespace unibody
