#include "scene/surface_file.hpp"

#include "scene/obj.hpp"
#include "scene/stl.hpp"

namespace unibody {

TriangleMesh read_surface(const std::string& path) {
  return path.ends_with(".stl") || path.ends_with(".STL") ? read_stl(path) : read_obj(path);
}

}  // namespace unibody
