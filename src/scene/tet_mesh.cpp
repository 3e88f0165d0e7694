#include "scene/tet_mesh.hpp"

#include "core/errors.hpp"
#include "scene/msh.hpp"
#include "scene/tet_topology.hpp"

namespace unibody {

TetMesh read_tet_mesh(const std::string& path) {
  if (!path.ends_with(".msh"))
    throw InputError(path + ": found a mesh of tetrahedra of unknown format, expected a file .msh (Gmsh)");
  TetMesh mesh = read_msh(path);
  drop_unused_nodes(mesh);
  orient_tets(mesh, path);
  check_tets(mesh, path);
  return mesh;
}

}  // namespace unibody
