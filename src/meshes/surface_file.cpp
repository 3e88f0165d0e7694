#include "meshes/surface_file.hpp"

#include <algorithm>
#include <cctype>

#include "meshes/assimp_surface.hpp"
#include "meshes/obj.hpp"
#include "meshes/ply.hpp"
#include "meshes/stl.hpp"

namespace unibody {

TriangleMesh read_surface(const std::string& path, bool soup) {
  std::string name = path;
  std::ranges::transform(name, name.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (is_for_assimp(name)) return read_by_assimp(path, soup);
  if (name.ends_with(".ply")) return read_ply(path, soup);
  return name.ends_with(".stl") ? read_stl(path, soup) : read_obj(path, soup);
}

}  // namespace unibody
