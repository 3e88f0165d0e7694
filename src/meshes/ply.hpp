// Triangle meshes from PLY files, the polygon format of Stanford: text, or binary in either byte order.
#pragma once

#include <string>

#include "meshes/triangle_mesh.hpp"

namespace unibody {

// Reads the places (x, y, z) of the element `vertex` and the lists `vertex_indices` or `vertex_index` of the element `face`, in
// the order of the file; lengths in m. Faces of four or more corners, which must be convex, are cut into triangles that fan out
// from their first corner. Other elements and properties are skipped. Throws InputError "file:line: found v, expected e" on the
// first fault, without a line where it is in the data; a node twice in a face is one unless `soup`.
TriangleMesh read_ply(const std::string& path, bool soup = false);

}  // namespace unibody
