// A closed surface as convex solids, for contact.
#pragma once

#include "meshes/triangle_mesh.hpp"
#include "world/hull.hpp"

namespace unibody {

// Cuts the surface into cubic cells, `cells` of them along its longest side, and takes the convex hull of what lies in each: the
// hulls cover the surface, and reach out of the solid at hollows by no more than what a cell's part of the surface bends in.
// Cells that the surface does not enter have none; flat parts become plates as thick as a hundredth of a cell, inwards.
std::vector<Hull> convex_pieces(const TriangleMesh& mesh, int cells);

// The convex solids that a surface consists of: each part of it whose triangles share nodes is one, as programs of convex
// decomposition write them. Throws std::invalid_argument with what was found where a part spans no volume, or encloses less than
// 99 % of its hull: it is not convex.
std::vector<Hull> convex_parts(const TriangleMesh& mesh);

}  // namespace unibody
