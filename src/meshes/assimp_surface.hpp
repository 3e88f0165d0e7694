// Surfaces from the formats of other programs that the library assimp reads.
#pragma once

#include <string>

#include "meshes/triangle_mesh.hpp"

namespace unibody {

// Whether the name ends as that of a glTF or Collada file: .gltf, .glb or .dae, in small or large letters.
bool is_for_assimp(const std::string& path);

// Reads all triangles of a file, where its own tree of nodes places them, in metres (a Collada file says its unit); which axis
// points up makes no difference. Corners at the same place become one node. Numbers have single precision. Throws InputError
// where assimp finds a fault, where there is no triangle, where one has a corner twice and soup is false, and where the program
// was built without assimp.
TriangleMesh read_by_assimp(const std::string& path, bool soup);

}  // namespace unibody
