#include "meshes/surface_file.hpp"

#include "meshes/obj.hpp"
#include "meshes/stl.hpp"

namespace unibody {

TriangleMesh read_surface(const std::string& path, bool soup) {
  return path.ends_with(".stl") || path.ends_with(".STL") ? read_stl(path, soup) : read_obj(path, soup);
}

}  // namespace unibody
