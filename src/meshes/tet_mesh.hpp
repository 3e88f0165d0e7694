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

// A mesh as a file gave it, and what was done to it.
struct ReadTetMesh {
  TetMesh mesh;
  std::vector<std::int32_t> number;  // of each node of the file that is in a tet, in their order: that in the mesh
  std::string note;                  // what a person should know; may be empty
};

// Reads a mesh by the end of its name, .msh (Gmsh) or .vtu (VTK): nodes of no tet are dropped, nodes nearer than that share of
// the mesh's extent are welded (weld.hpp), inverted tets turned over, and check_tets() has passed. Throws InputError "file:line:
// found v, expected e".
ReadTetMesh read_tet_mesh(const std::string& path, double weld_share);

}  // namespace unibody
