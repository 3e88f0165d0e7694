// Solids from files of tetrahedra.
#include <filesystem>
#include <memory>

#include "meshes/tet_mesh.hpp"
#include "meshes/tet_topology.hpp"
#include "scene/mesh_constraints.hpp"
#include "scene/solid_shape.hpp"

namespace unibody {

namespace {

struct MeshSolid {
  TetMesh mesh;
  std::vector<double> mass;  // kg, of each node
  MeshConstraints constraints;
  std::vector<std::array<std::int32_t, 3>> surface;
  Incidence triangles_of;
  std::vector<std::int32_t> number;  // of each node of the file, that in the mesh

  MeshSolid(ReadTetMesh given, const SolidLaw& law)
      : mesh(std::move(given.mesh)), mass(mesh.nodes.size(), 0), number(std::move(given.number)) {
    ConstraintSet set;
    for (const auto& n : mesh.tets) {
      std::array<Vec3, 4> at;
      std::array<Id, 4> ids;
      for (std::size_t e = 0; e < 4; ++e) ids[e] = n[e], at[e] = mesh.nodes[static_cast<std::size_t>(n[e])];
      add_tetrahedron(law, at, ids, 0, set);
      const double volume = (at[1] - at[0]).dot((at[2] - at[0]).cross(at[3] - at[0])) / 6;
      for (const std::int32_t node : n) mass[static_cast<std::size_t>(node)] += law.density * volume / 4;
    }
    const auto count = static_cast<Id>(mesh.nodes.size());
    constraints = MeshConstraints(std::move(set), count);
    surface = boundary_of(mesh);
    triangles_of = Incidence(surface, count, [](const auto& nodes) { return nodes; });
  }
};

ReadTetMesh read_mesh(const Value& file, const MeshScale& scale, double weld_share, const Scene& scene) {
  namespace fs = std::filesystem;
  const std::string path = (fs::path(scene.path).parent_path() / file.string("a .msh or .vtu file")).string();
  std::error_code error;
  if (!fs::is_regular_file(path, error))
    file.fail(path + (fs::exists(path, error) ? ", which isn't a file" : ", which isn't there"),
              std::string("a .msh or .vtu file, its path from the scene's folder") +
                  (path.find("results/meshes/") != path.npos ? " (scripts/get-meshes fetches it)" : ""));
  ReadTetMesh read = read_tet_mesh(path, weld_share);
  scale.apply(read.mesh.nodes);
  return read;
}

}  // namespace

MeshShape mesh_solid(const Value& file, const MeshScale& scale, double weld_share, const SolidLaw& law, const Scene& scene) {
  ReadTetMesh read = read_mesh(file, scale, weld_share, scene);
  MeshShape shape;
  shape.note = read.note;
  const auto solid = std::make_shared<const MeshSolid>(std::move(read), law);
  shape.count = static_cast<Id>(solid->mesh.nodes.size());
  shape.place = [solid](Id k) { return solid->mesh.nodes[static_cast<std::size_t>(k)]; };
  shape.mass = [solid](Id k) { return solid->mass[static_cast<std::size_t>(k)]; };
  shape.touching = [solid](Id first, Id node, ConstraintSet& out) { solid->constraints.touching(first, node, out); };
  shape.number = [solid](const Value& node) -> Id {
    return solid->number[static_cast<std::size_t>(node.integer(0, std::ssize(solid->number) - 1))];
  };
  shape.triangle_count = static_cast<Id>(solid->surface.size());
  shape.triangle = [solid](Id t) -> std::array<Id, 3> {
    const auto& n = solid->surface[static_cast<std::size_t>(t)];
    return {n[0], n[1], n[2]};
  };
  shape.triangles_of = [solid](Id node, std::vector<std::array<Id, 3>>& out) {
    for (const std::size_t t : solid->triangles_of.at(node)) {
      const auto& n = solid->surface[t];
      out.push_back({n[0], n[1], n[2]});
    }
  };
  shape.tetrahedron_count = static_cast<Id>(solid->mesh.tets.size());
  shape.tetrahedron = [solid](Id t) -> std::array<Id, 4> {
    const auto& n = solid->mesh.tets[static_cast<std::size_t>(t)];
    return {n[0], n[1], n[2], n[3]};
  };
  return shape;
}

}  // namespace unibody
