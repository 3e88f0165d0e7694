// The files from which surfaces of triangles are read.
#pragma once

#include <string>

#include "meshes/triangle_mesh.hpp"

namespace unibody {

// Reads a surface as read_stl() does where the name ends in .stl or .STL, else as read_obj().
TriangleMesh read_surface(const std::string& path, bool soup = false);

}  // namespace unibody
