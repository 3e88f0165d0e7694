// Meshes of tetrahedra from VTK's XML files.
#pragma once

#include <string>

#include "meshes/tet_mesh.hpp"

namespace unibody {

// Reads the points and the tetrahedra (cell type 10) of an unstructured grid of one piece; lengths in m. Arrays are text, inline
// binary, or appended (raw or base64); plain or compressed with zlib. Cells of lower dimension and all data on points and cells
// are skipped. Nodes of no tet and inverted tets are kept: see tet_topology.hpp.
//
// Throws InputError "file:line: found v, expected e" on the first fault: a missing file, bad XML, another byte order or
// compressor, volume cells other than tetrahedra of 4 points, an array of another type or length, a point that isn't there, no
// tetrahedra.
TetMesh read_vtu(const std::string& path);

}  // namespace unibody
