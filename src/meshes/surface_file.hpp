// The files from which surfaces of triangles are read.
#pragma once

#include <string>

#include "meshes/triangle_mesh.hpp"

namespace unibody {

// Reads a surface as read_by_assimp() does where the name ends in .ply, .gltf, .glb or .dae, as read_stl() where it ends in .stl
// or .STL, else as read_obj().
TriangleMesh read_surface(const std::string& path, bool soup = false);

}  // namespace unibody
