// Triangle meshes from STL files.
#pragma once

#include <string>

#include "meshes/triangle_mesh.hpp"

namespace unibody {

// Reads a binary STL file (80 bytes that are skipped, a count, 50 bytes a triangle) or one in ASCII (`solid` .. `endsolid`, also
// several); lengths in m. Which of the two it is its length says: binary files, too, may begin with "solid". Corners that are
// equal in all three coordinates are one node, numbered in the order in which they come first; corners that differ in the last
// bit stay apart, and leave a crack that whoever needs a closed surface refuses. Normals, names and attributes are skipped: the
// corners turn counterclockwise as seen from outside.
//
// It is no library's reader, which join corners by a distance of their own or not at all: here only equal ones are one node, in
// the order of the file, and a fault ends with its line or triangle.
//
// Throws InputError "file:line: found v, expected e" (binary: "file: found v in triangle k, expected e", k from 1) on the first
// fault: a missing file, one that is cut off, any other word, a bad number, a triangle with a corner twice (which a `soup` keeps,
// scene/triangle_soup.hpp), no triangles.
TriangleMesh read_stl(const std::string& path, bool soup = false);

}  // namespace unibody
