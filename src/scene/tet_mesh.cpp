#include "scene/tet_mesh.hpp"

#include "core/errors.hpp"
#include "scene/msh.hpp"
#include "scene/tet_topology.hpp"
#include "scene/vtu.hpp"

namespace unibody {

TetMesh read_tet_mesh(const std::string& path) {
  const bool msh = path.ends_with(".msh");
  if (!msh && !path.ends_with(".vtu"))
    throw InputError(path + ": found a mesh of tetrahedra of unknown format, expected a file .msh (Gmsh) or .vtu (VTK)");
  TetMesh mesh = msh ? read_msh(path) : read_vtu(path);
  drop_unused_nodes(mesh);
  orient_tets(mesh, path);
  check_tets(mesh, path);
  return mesh;
}

}  // namespace unibody
