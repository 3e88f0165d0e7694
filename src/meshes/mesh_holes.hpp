// Holes in a surface: borders that are small beside the part of the surface that they are in. A border as wide as its part is an
// outline, as that of a terrain, or the rim of a container.
#pragma once

#include <vector>

#include "meshes/triangle_mesh.hpp"

namespace unibody {

struct Hole {
  std::int64_t edges = 0;      // of one triangle alone
  double width = 0;            // m, the longest edge of the box around them
  Vec3 centre = Vec3::Zero();  // m, of that box
};

// The widest first. Edges of three or more triangles are no border.
std::vector<Hole> holes_of(const TriangleMesh& mesh);

}  // namespace unibody
