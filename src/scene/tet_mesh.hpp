// A mesh of tetrahedra as plain data: what files give, and what soft bodies are built from.
#pragma once

#include <array>
#include <string>

#include "core/types.hpp"

namespace unibody {

// Both nodes and tets are numbered from 0.
struct TetMesh {
  std::vector<Vec3> nodes;                        // m
  std::vector<std::array<std::int32_t, 4>> tets;  // nodes of each, det[x1 - x0, x2 - x0, x3 - x0] > 0
};

// Reads a mesh by the end of its name, .msh (Gmsh) or .vtu (VTK): nodes of no tet are dropped, inverted tets turned over, and
// check_tets() has passed. Throws InputError "file:line: found v, expected e".
TetMesh read_tet_mesh(const std::string& path);

}  // namespace unibody
