// Triangle meshes from Wavefront OBJ files.
#pragma once

#include <string>

#include "meshes/triangle_mesh.hpp"

namespace unibody {

// Reads the nodes (`v`) and the faces (`f`) of an OBJ file, in the order of the file; lengths in m. A face's corner is a, a/b,
// a//c or a/b/c, of which only the node a counts: from 1 on, or negative and counted back from the last node so far. Faces of
// four or more corners are cut into triangles that fan out from the first corner; they must be convex. Skipped: comments, vn, vt,
// vp, l, o, g, s, usemtl, mtllib, and the weight or colour that may follow a node's coordinates.
//
// It is no library's reader, which skip or mend what they don't know: here a fault ends with its line, and nodes keep the numbers
// of the file, by which scenes pin them.
//
// Throws InputError "file:line: found v, expected e" on the first fault: a missing file, any other statement, a bad number, a
// node that isn't there or comes twice in one face (of a triangle a `soup` keeps that, scene/triangle_soup.hpp), a face that
// isn't convex, no faces.
TriangleMesh read_obj(const std::string& path, bool soup = false);

}  // namespace unibody
