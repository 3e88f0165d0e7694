// Meshes of tetrahedra from Gmsh's files.
#pragma once

#include <string>

#include "meshes/tet_mesh.hpp"

namespace unibody {

// Reads nodes and tetrahedra of a Gmsh file: .msh 2.2 or 4.1, text or little-endian binary; lengths in m. Tags may have gaps and
// stand in any order: nodes and tets are numbered in ascending order of their tags. Skipped: elements of lower dimension,
// sections other than $Nodes and $Elements, parametric coordinates. Nodes of no tet and inverted tets are kept: see
// tet_topology.hpp.
//
// Throws InputError "file:line: found v, expected e" on the first fault: a missing file, another version or byte order, volume
// elements other than tetrahedra of 4 nodes, a number that is bad or missing, a tag twice, a node that isn't there, no
// tetrahedra. In binary data the fault has no line, but the number of its byte.
TetMesh read_msh(const std::string& path);

}  // namespace unibody
