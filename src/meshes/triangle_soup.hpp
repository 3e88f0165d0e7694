// Triangle meshes as they come, for surfaces that do not move: what a file may say wrongly and still be terrain.
#pragma once

#include <string>

#include "meshes/triangle_mesh.hpp"

namespace unibody {

struct SoupFaults {
  std::int64_t without_area = 0, repeated = 0;  // triangles that were left out
  std::int64_t welded = 0;                      // nodes near others, but not at the same place to the last bit, that became one
  bool both_ways = false;                       // some that were left out turn the other way than those that stay
};

// Makes a mesh sound enough for make_mesh_shape(): nodes at the same place, to the last bit, become one, and those that are
// nearer to each other than weld_share of the mesh's extent (weld.hpp); triangles with a node twice or a height below 1e-8 of
// their longest edge are left out, and those that have the nodes of an earlier one; nodes of no triangle too. A mesh that has no
// border and no fault stays as it is. Throws InputError "origin: found v, expected e" on a node that isn't there, and where no
// triangle is left.
SoupFaults mend_soup(TriangleMesh& mesh, const std::string& origin, double weld_share = 0);

}  // namespace unibody
