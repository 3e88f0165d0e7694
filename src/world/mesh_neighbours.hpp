// Which triangles of a mesh shape go on over which edges, and which sides of them belong together.
#pragma once

#include "world/mesh_shape.hpp"

namespace unibody {

// Fills in what the triangles of a mesh know of each other, from their nodes: across, speaks_for_edge, speaks_for_node, patch;
// and the mesh's rings and branchings. Where two triangles at an edge are wound against each other the mesh becomes two-sided:
// its triangles are then turned over until those of a patch agree, and what cannot agree, as on a Moebius strip, is cut.
void join_neighbours(MeshSurface& mesh);

}  // namespace unibody
