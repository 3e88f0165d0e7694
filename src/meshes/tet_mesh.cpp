#include "meshes/tet_mesh.hpp"

#include "core/errors.hpp"
#include "meshes/msh.hpp"
#include "meshes/tet_topology.hpp"
#include "meshes/vtu.hpp"
#include "meshes/weld.hpp"

namespace unibody {

ReadTetMesh read_tet_mesh(const std::string& path, double weld_share) {
  const bool msh = path.ends_with(".msh");
  if (!msh && !path.ends_with(".vtu"))
    throw InputError(path + ": found a mesh of tetrahedra of unknown format, expected a file .msh (Gmsh) or .vtu (VTK)");
  ReadTetMesh read{msh ? read_msh(path) : read_vtu(path), {}, {}};
  TetMesh& mesh = read.mesh;
  drop_unused_nodes(mesh);
  const std::size_t before = mesh.nodes.size();
  read.number = weld(mesh.nodes, weld_share * extent_of(mesh.nodes));
  const std::int64_t dropped = before == mesh.nodes.size() ? 0 : renumber(mesh.tets, read.number);
  orient_tets(mesh, path);
  check_tets(mesh, path);
  const std::string note =
      weld_note(before, mesh.nodes.size(), dropped, "tetrahedron", count_parts(mesh.nodes.size(), mesh.tets));
  if (!note.empty()) read.note = path + ": " + note;
  return read;
}

}  // namespace unibody
