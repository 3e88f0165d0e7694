// Mesh cloths: nodes and triangles of an OBJ, STL, PLY, glTF or DAE file.
#include <algorithm>
#include <memory>
#include <set>

#include "meshes/mesh_topology.hpp"
#include "meshes/surface_file.hpp"
#include "meshes/weld.hpp"
#include "scene/cloth_shape.hpp"
#include "scene/mesh_constraints.hpp"
#include "scene/shape_files.hpp"

namespace unibody {

namespace {

// Constraints with nodes in place of ids.
class ClothConstraints {
 public:
  ClothConstraints(const TriangleMesh& mesh, const MeshTopology& topology, const ClothLaw& law) : mesh_(mesh) {
    if (law.links)
      for (const MeshEdge& edge : topology.edges) add_link<Distance>(*law.links, edge.nodes[0], edge.nodes[1]);
    if (law.membrane) add_on_triangles<Membrane>([&](const auto&... at) { return membrane_at_rest(*law.membrane, at...); });
    if (law.area) add_on_triangles<Area>([&](const auto&... at) { return area_at_rest(*law.area, at...); });
    if (law.bending && law.bending->dihedral) add_angles(topology, law.bending->spring);
    if (law.bending && !law.bending->dihedral) add_links_across(topology, law.bending->spring);
  }
  ConstraintSet set;

 private:
  const Vec3& place(Id node) const { return mesh_.nodes[static_cast<std::size_t>(node)]; }

  template <class Link>
  void add_link(const Spring& spring, Id a, Id b) {
    auto c = link_at_rest<Link>(spring, place(a), place(b));
    c.ids = {a, b};
    std::get<ConstraintList<Link>>(set).push_back(c);
  }

  template <class C, typename AtRest>
  void add_on_triangles(AtRest&& at_rest) {
    for (const auto& n : mesh_.triangles) {
      Constraint<C> c = at_rest(place(n[0]), place(n[1]), place(n[2]));
      c.ids = {n[0], n[1], n[2]};
      std::get<ConstraintList<C>>(set).push_back(c);
    }
  }

  // Between the corners that face each other over an edge: once also where two edges have the same ones.
  void add_links_across(const MeshTopology& topology, const Spring& spring) {
    std::set<std::array<Id, 2>> pairs;
    for (const MeshEdge& edge : topology.edges)
      if (!edge.is_boundary() && edge.opposite[0] != edge.opposite[1])
        pairs.insert({std::min(edge.opposite[0], edge.opposite[1]), std::max(edge.opposite[0], edge.opposite[1])});
    for (const auto& [a, b] : pairs) add_link<BendingLink>(spring, a, b);
  }

  void add_angles(const MeshTopology& topology, const Spring& spring) {
    for (const MeshEdge& edge : topology.edges) {
      if (edge.is_boundary()) continue;
      const Id p = edge.nodes[0], q = edge.nodes[1];
      const auto& n = mesh_.triangles[static_cast<std::size_t>(edge.triangles[0])];
      const auto at = std::find(n.begin(), n.end(), p) - n.begin();
      const bool up = n[static_cast<std::size_t>(at + 1) % 3] == q;  // the first triangle is p, q, and its opposite corner
      const Id r = edge.opposite[up ? 0 : 1], s = edge.opposite[up ? 1 : 0];
      auto c = angle_at_rest(spring, angle(p, q, r, s), (place(p) - place(q)).norm());
      c.ids = {p, q, r, s};
      std::get<ConstraintList<Dihedral>>(set).push_back(c);
    }
  }

  // The angle as the constraint's own type evaluates it, so that the rest shape is at rest exactly.
  double angle(Id p, Id q, Id r, Id s) const {
    std::array<Vec3x4, 4> x;
    const std::array<Id, 4> nodes{p, q, r, s};
    for (std::size_t k = 0; k < 4; ++k)
      x[k] = {broadcast(place(nodes[k]).x()), broadcast(place(nodes[k]).y()), broadcast(place(nodes[k]).z())};
    Rows<4, 1> rows;
    Dihedral::evaluate({broadcast(0), broadcast(1)}, x, rows);
    return rows.value[0][0];
  }

  const TriangleMesh& mesh_;
};

struct MeshCloth {
  TriangleMesh mesh;
  std::vector<std::int32_t> number;  // of each node of the file, that in the mesh
  std::string note;
  std::vector<double> mass;  // kg, of each node
  MeshConstraints constraints;
  Incidence triangles_of;

  MeshCloth(TriangleMesh given, double weld_share, const std::string& origin, const ClothLaw& law) : mesh(std::move(given)) {
    const std::size_t before = mesh.nodes.size();
    number = weld(mesh.nodes, weld_share * extent_of(mesh.nodes));
    const bool welded = mesh.nodes.size() < before;
    const std::int64_t dropped = welded ? renumber(mesh.triangles, number) : 0;
    const MeshTopology topology = mesh_topology(mesh, welded ? origin + ", its nodes welded (weld: 0 keeps them apart)" : origin);
    note = weld_note(before, mesh.nodes.size(), dropped, "triangle", topology.components);
    if (!note.empty()) note = origin + ": " + note;
    orient_triangles(mesh, topology, origin);
    check_mesh(mesh, origin);
    constraints = MeshConstraints(ClothConstraints(mesh, topology, law).set, static_cast<Id>(mesh.nodes.size()));
    triangles_of = Incidence(mesh.triangles, static_cast<Id>(mesh.nodes.size()), [](const auto& nodes) { return nodes; });
    set_masses(law);
  }

 private:
  // A third of each triangle's at each of its corners.
  void set_masses(const ClothLaw& law) {
    mass.assign(mesh.nodes.size(), law.by_area ? 0 : law.mass / static_cast<double>(mesh.nodes.size()));
    if (!law.by_area) return;
    const auto place = [&](std::int32_t node) -> const Vec3& { return mesh.nodes[static_cast<std::size_t>(node)]; };
    for (const auto& n : mesh.triangles) {
      const double area = 0.5 * (place(n[1]) - place(n[0])).cross(place(n[2]) - place(n[0])).norm();
      for (const std::int32_t node : n) mass[static_cast<std::size_t>(node)] += law.mass * area / 3;
    }
  }
};

TriangleMesh read_mesh(const Value& file, const Scene& scene, std::string& path) {
  path = surface_path(file, scene);
  return read_surface(path);
}

}  // namespace

MeshShape mesh_cloth(const Value& file, const MeshScale& scale, double weld_share, const ClothLaw& law, const Scene& scene) {
  std::string path;
  TriangleMesh mesh = read_mesh(file, scene, path);
  scale.apply(mesh.nodes);
  const auto cloth = std::make_shared<const MeshCloth>(std::move(mesh), weld_share, path, law);
  MeshShape shape;
  shape.note = cloth->note;
  shape.count = static_cast<Id>(cloth->mesh.nodes.size());
  shape.place = [cloth](Id k) { return cloth->mesh.nodes[static_cast<std::size_t>(k)]; };
  shape.mass = [cloth](Id k) { return cloth->mass[static_cast<std::size_t>(k)]; };
  shape.touching = [cloth](Id first, Id node, ConstraintSet& out) { cloth->constraints.touching(first, node, out); };
  shape.number = [cloth](const Value& node) -> Id {
    return cloth->number[static_cast<std::size_t>(node.integer(0, std::ssize(cloth->number) - 1))];
  };
  shape.triangle_count = static_cast<Id>(cloth->mesh.triangles.size());
  shape.triangle = [cloth](Id t) -> std::array<Id, 3> {
    const auto& n = cloth->mesh.triangles[static_cast<std::size_t>(t)];
    return {n[0], n[1], n[2]};
  };
  shape.triangles_of = [cloth](Id node, std::vector<std::array<Id, 3>>& out) {
    for (const std::size_t t : cloth->triangles_of.at(node)) {
      const auto& n = cloth->mesh.triangles[t];
      out.push_back({n[0], n[1], n[2]});
    }
  };
  return shape;
}

}  // namespace unibody
