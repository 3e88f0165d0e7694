// Cloths of meshes against the same cloth as a grid; colours of both; pins by place.
#include <algorithm>
#include <map>
#include <set>
#include <sstream>

#include "meshes/mesh_topology.hpp"
#include "scene/grid_mesh.hpp"
#include "scene/scene_text.hpp"
#include "small_worlds.hpp"

namespace unibody::mesh_cloth_test {
namespace {

constexpr std::array<std::int32_t, 2> size{7, 6};  // nodes

// The grid's mesh as OBJ text, its nodes in the opposite order.
std::string grid_as_obj() {
  const TriangleMesh mesh = grid_mesh({0.6, 0.5}, size);
  std::ostringstream text;
  text.precision(17);
  for (auto node = mesh.nodes.rbegin(); node != mesh.nodes.rend(); ++node) text << "v " << node->transpose() << '\n';
  for (const auto& t : mesh.triangles) {
    text << 'f';
    for (const std::int32_t node : t) text << ' ' << static_cast<std::int32_t>(mesh.nodes.size()) - node;
    text << '\n';
  }
  return text.str();
}

std::string cloth(const std::string& shape, const std::string& law, const std::string& pins = "") {
  return "cloths:\n  - " + shape + "\n    " + law + "\n    mass: 2\n    thickness: 0.01\n    position: [0, 0, 3]\n" +
         (pins.empty() ? "" : "    pins: " + pins + "\n");
}
const std::string grid = "grid: {size: [0.6, 0.5], nodes: [7, 6]}";
std::string mesh(const TextFile& file) { return "mesh: " + file.path().substr(file.path().rfind('/') + 1); }

ConstraintSet constraints_of(const Scene& scene) {
  ConstraintSet all;
  for (const ConstraintGroup& group : scene.constraint_groups)
    for (Id id = group.first; id < group.first + group.count; ++id) group.touching(id, all);
  return all;
}

// Constraints as sets, with the numbers of `renamed` nodes; a bending angle is the same from both sides.
template <class C>
std::map<std::set<Id>, Constraint<C>> as_set(const ConstraintSet& set, Id renamed) {
  std::map<std::set<Id>, Constraint<C>> result;
  for (const auto& c : std::get<ConstraintList<C>>(set)) {
    std::set<Id> ids;
    for (const Id id : c.ids) ids.insert(renamed > 0 ? renamed - 1 - id : id);
    result.emplace(ids, c);
  }
  return result;
}

template <class C>
void expect_same(const ConstraintSet& of_grid, const ConstraintSet& of_mesh, bool parameters) {
  const auto a = as_set<C>(of_grid, 0), b = as_set<C>(of_mesh, size[0] * size[1]);
  ASSERT_EQ(a.size(), b.size()) << C::name;
  for (const auto& [ids, c] : a) {
    ASSERT_TRUE(b.contains(ids)) << C::name;
    for (std::size_t k = 0; parameters && k < c.parameters.size(); ++k)
      EXPECT_NEAR(c.parameters[k], b.at(ids).parameters[k], 1e-12) << C::name << ' ' << k;
    for (std::size_t k = 0; k < c.compliance.size(); ++k)
      EXPECT_NEAR(c.compliance[k], b.at(ids).compliance[k], 1e-12 * c.compliance[k]) << C::name;
  }
}

void expect_proper_colours(const Scene& scene) {
  const ConstraintSet constraints = constraints_of(scene);
  for_each_type(constraints, [](auto, const auto& list) {
    std::map<std::pair<std::int32_t, Id>, decltype(list[0].ids)> owner;
    for (const auto& c : list)
      for (const Id id : c.ids) {
        const auto at = owner.emplace(std::pair(c.colour, id), c.ids).first;
        ASSERT_EQ(at->second, c.ids) << "node " << id << " twice in colour " << c.colour;
      }
  });
}

const std::string laws[] = {
    "links: {diagonals: alternating}", "links: {stiffness: 100}\n    bending: {stiffness: 2}",
    "membrane: {youngs_modulus: 1.0e4, poissons_ratio: 0.3}\n    bending: {model: dihedral, stiffness: 0.01}",
    "links: {stiffness: 100, diagonals: alternating}\n    area: {stiffness: 50, damping: 0.02}"};

TEST(MeshCloth, IsTheGridThatItWasWrittenFrom) {
  const TextFile file(grid_as_obj());
  for (const std::string& law : {laws[0], laws[2], laws[3]}) {
    const Scene a = scene_from(cloth(grid, law));
    std::string of_mesh = law;
    if (const auto at = of_mesh.find("diagonals: alternating"); at != std::string::npos) of_mesh.erase(at, 22);
    const Scene b = scene_from(cloth(mesh(file), of_mesh));
    const Id count = a.body_count();
    ASSERT_EQ(b.body_count(), count);
    for (Id id = 0; id < count; ++id) {
      EXPECT_EQ(a.body(id).properties.mass, b.body(id).properties.mass);
      EXPECT_EQ(a.body(id).state.position, b.body(count - 1 - id).state.position);
    }
    const ConstraintSet x = constraints_of(a), y = constraints_of(b);
    expect_same<Distance>(x, y, true);
    expect_same<Membrane>(x, y, false);  // its axes depend on the corner that comes first
    expect_same<Dihedral>(x, y, true);
    expect_same<Area>(x, y, true);
    EXPECT_GT(constraint_count(x), 100u);
  }
}

// From different orders of nodes and colours. Constraints are evaluated anew in each pass, so that the impulses of Gauss-Seidel's
// incremental form keep a trace of the path by which they came, also after many iterations (without momentum 5e-5 m here): it is
// less than that form is away from implicit Euler, to which the total form converges.
TEST(MeshCloth, MovesAsTheGrid) {
  const TextFile file(grid_as_obj());
  for (const std::string solver : {"accelerated_jacobi", "gauss_seidel", "gauss_seidel, acceleration: none"}) {
    const std::string settings = "solver: {name: " + solver + ", iterations: 1000, tolerance: 0}\n";
    const std::string law = "links: {stiffness: 500, damping: 0.05";
    small_worlds::Experiment a(
        scene_from(cloth(grid, law + ", diagonals: alternating}", "[{node: [0, 0]}, {node: [6, 0]}]") + settings));
    small_worlds::Experiment b(scene_from(cloth(mesh(file), law + "}", "[{node: 41}, {node: 35}]") + settings));
    a.steps(30), b.steps(30);
    double bound = solver == "accelerated_jacobi" ? 1e-6 : 1e-3;
    if (solver == "gauss_seidel") {
      small_worlds::Experiment exact(
          scene_from(cloth(grid, law + ", diagonals: alternating}", "[{node: [0, 0]}, {node: [6, 0]}]") +
                     "solver: {name: gauss_seidel, iterations: 1000, tolerance: 0, form: total}\n"));
      exact.steps(30);
      for (Id id = 0; id < 42; ++id) bound = std::max(bound, (a.position(id) - exact.position(id)).norm());
    }
    for (Id id = 0; id < 42; ++id) ASSERT_LT((a.position(id) - b.position(41 - id)).norm(), bound) << solver << ", node " << id;
    EXPECT_LT(a.position(41).z(), 2.8) << "it must have moved";
  }
}

TEST(MeshCloth, ColoursAreProper) {
  const TextFile file(grid_as_obj());
  const TextFile fan(
      "v 0 0 0\nv 1 0 0\nv 0 1 0\nv -1 0 0\nv 0 -1 0\nv 0 0 1\nf 1 2 3\nf 1 3 4\nf 1 4 5\nf 2 6 3\nf 3 6 4\nf 4 6 5\n");
  const std::string more[] = {"links: {diagonals: both}\n    bending: {}", "links: {}\n    bending: {model: dihedral}",
                              "links: {stiffness: 100}\n    area: {}"};
  for (const std::string& law : {laws[0], laws[1], laws[2], laws[3], more[0], more[1], more[2]}) {
    expect_proper_colours(scene_from(cloth(grid, law)));
    if (law.find("diagonals") == std::string::npos) {
      expect_proper_colours(scene_from(cloth(mesh(file), law)));
      expect_proper_colours(scene_from(cloth(mesh(fan), law)));
    }
  }
}

// One on each triangle that is drawn, at rest as it lies there, with any diagonals: k (A - A0)^2 / (2 A0) is c^2 / (2 E).
TEST(MeshCloth, AreasAreThoseOfTheTriangles) {
  const TextFile file(grid_as_obj()), roof("v 0 0 0\nv 0 1 0\nv -1 0.5 -0.3\nv 1 0.5 -0.4\nf 2 3 1\nf 2 1 4\n");
  const double k = 50;
  const std::string area = "\n    area: {stiffness: 50, damping: 0.02}", soft = "links: {stiffness: 100}" + area;
  for (const auto& [text, count, total] :
       {std::tuple(cloth(grid, soft), 60, 0.3), std::tuple(cloth(grid, "links: {diagonals: none}" + area), 60, 0.3),
        std::tuple(cloth(mesh(file), soft), 60, 0.3), std::tuple(cloth(mesh(file) + "\n    scale: 2", soft), 60, 1.2),
        std::tuple(cloth(mesh(roof), soft), 2, 0.5 * std::hypot(1, 0.3) + 0.5 * std::hypot(1, 0.4))}) {
    const Scene scene = scene_from(text);
    const ConstraintSet constraints = build_constraints(scene, build_world(MPI_COMM_SELF, scene));
    const auto& list = std::get<ConstraintList<Area>>(constraints);
    ASSERT_EQ(list.size(), static_cast<std::size_t>(count)) << text;
    std::set<std::set<Id>> of_triangles, of_constraints;
    for (Id t = 0; t < scene.surfaces[0].count; ++t) {
      const auto ids = scene.surfaces[0].cell(t);
      of_triangles.emplace(ids.begin(), ids.end());
    }
    double sum = 0;
    for (const auto& c : list) {
      of_constraints.emplace(c.ids.begin(), c.ids.end());
      const auto at = [&](std::size_t i) { return scene.body(c.ids[i]).state.position; };
      const double a = (at(1) - at(0)).norm(), b = (at(2) - at(1)).norm(), d = (at(0) - at(2)).norm(), s = (a + b + d) / 2;
      EXPECT_NEAR(c.parameters[0], std::sqrt(s * (s - a) * (s - b) * (s - d)), 1e-13) << "Heron's formula";
      EXPECT_NEAR(c.compliance[0] * c.parameters[1] * c.parameters[1], c.parameters[0] / k, 1e-14);
      EXPECT_EQ(c.damping, 0.02);
      sum += c.parameters[0];
    }
    EXPECT_EQ(of_constraints, of_triangles) << text;
    EXPECT_NEAR(sum, total, 1e-13) << text;
  }
  const Scene stiff = scene_from(cloth(grid, "links: {diagonals: none}\n    area: {}"));
  const ConstraintSet constraints = constraints_of(stiff);
  EXPECT_EQ(std::get<ConstraintList<Area>>(constraints)[0].compliance[0], 0);
}

TEST(MeshCloth, MassesSumToTheTotal) {
  const TextFile file(grid_as_obj());
  for (const std::string& shape : {grid, mesh(file), mesh(file) + "\n    scale: 2"})
    for (const bool by_area : {false, true}) {
      std::string text = cloth(shape, "links: {}");
      if (by_area) text.replace(text.find("mass: 2"), 7, "mass_per_area: 2");
      const Scene scene = scene_from(text);
      double sum = 0;
      for (Id id = 0; id < scene.body_count(); ++id) sum += scene.body(id).properties.mass;
      EXPECT_NEAR(sum, !by_area ? 2 : shape.find("scale") == std::string::npos ? 2 * 0.3 : 2 * 1.2, 1e-14);
    }
}

// A curved mesh starts at rest, and its angles have the sign that their type gives them.
TEST(MeshCloth, CurvedMeshIsAtRest) {
  const TextFile roof("v 0 0 0\nv 0 1 0\nv -1 0.5 -0.3\nv 1 0.5 -0.4\nf 2 3 1\nf 2 1 4\n");
  const Scene scene = scene_from(cloth(mesh(roof), "links: {}\n    bending: {model: dihedral}") + "gravity: [0, 0, 0]\n");
  const ConstraintSet constraints = constraints_of(scene);
  EXPECT_NEAR(std::get<ConstraintList<Dihedral>>(constraints)[0].parameters[0], std::atan(0.3) + std::atan(0.4), 1e-15);
  small_worlds::Experiment run(scene);
  run.steps(10);
  for (Id id = 0; id < 4; ++id) EXPECT_LT((run.position(id) - scene.body(id).state.position).norm(), 1e-14);
}

// 4 x 4 nodes without the middle cell, whose edges stay: a ball falls through the hole, and lies on the cloth without one.
TEST(MeshCloth, AHoleIsAHole) {
  for (const bool hole : {false, true}) {
    const TriangleMesh whole = grid_mesh({0.6, 0.6}, {4, 4});
    std::ostringstream text;
    text.precision(17);
    for (const Vec3& x : whole.nodes) text << "v " << x.transpose() << '\n';
    for (const auto& t : whole.triangles) {
      Vec3 middle = Vec3::Zero();
      for (const std::int32_t node : t) middle += whole.nodes[static_cast<std::size_t>(node)] / 3;
      if (hole && middle.norm() < 0.1) continue;
      text << "f " << t[0] + 1 << ' ' << t[1] + 1 << ' ' << t[2] + 1 << '\n';
    }
    const TextFile file(text.str());
    Scene scene = scene_from(cloth(mesh(file), "links: {}", "[{within: {min: [-1, -1, 0], max: [1, 1, 9]}}]"));
    EXPECT_EQ(as_set<Distance>(constraints_of(scene), 0).size(), hole ? 32u : 33u);  // by Euler
    small_worlds::add(scene, small_worlds::ball(1, 0.05, Vec3(0, 0.02, 3.2)));
    small_worlds::Experiment run(std::move(scene));
    run.seconds(0.5);
    EXPECT_NEAR(run.position(16).z(), hole ? 3.2 - 9.81 * 0.016 * 0.016 * 31 * 32 / 2 : 3.055, hole ? 1e-9 : 1e-4) << hole;
  }
}

TEST(MeshCloth, PinsByPlace) {
  const TextFile file(grid_as_obj());
  const std::string pins = "[{near: [-0.36, -0.31, 3], release: 2}, {near: [0.31, 0.25, 3.1]}]";
  const Scene a = scene_from(cloth(grid, "links: {}", pins)), b = scene_from(cloth(mesh(file), "links: {}", pins));
  ASSERT_EQ(a.pins.size(), 2u);
  EXPECT_EQ(a.pins[0].id, 0);
  EXPECT_EQ(a.pins[1].id, 41);
  EXPECT_EQ(a.pins[0].release, 2);
  EXPECT_EQ(b.pins[0].id, 0);
  EXPECT_EQ(b.pins[0].release, std::numeric_limits<double>::infinity());
}

// Of a mesh's fault the message names the mesh and the place in it; of a file that isn't there, the scene and the key.
TEST(MeshCloth, FaultsAreNamed) {
  const auto fault = [](const std::string& obj) {
    const TextFile file(obj);
    std::string message = fault_of(cloth(mesh(file), "links: {}"));
    const auto at = message.find(file.path());
    return at == std::string::npos ? message : message.replace(at, file.path().size(), "MESH");
  };
  const std::string nodes = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nv 1 1 0\n";
  EXPECT_EQ(fault(nodes + "f 1 2 3\nf 1 2 9\n"), "MESH:7: found node 9 of 5 nodes, expected a node that is there");
  EXPECT_EQ(fault(nodes + "f 1 2 3\nf 2 1 4\nf 1 2 5\n"),
            "MESH: found triangles 0, 1 and 2 at the edge of nodes 0 and 1, expected at most two triangles at an edge");
  EXPECT_EQ(fault(nodes + "f 1 2 3\nf 3 1 2\n"),
            "MESH: found triangles 0 and 1 with the same nodes, expected each triangle once");
  EXPECT_EQ(fault("v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n"),
            "MESH: found triangle 0 without area, expected a height of 1e-8 of the longest edge");
  EXPECT_EQ(fault(nodes + "f 1 2 3\nf 2 5 3\n"), "MESH: found node 3 in no triangle, expected each node in a triangle");
  EXPECT_EQ(fault(nodes + "v 3 3 0\nf 1 2 3\nf 4 5 6\n"), "") << "two parts are a cloth";
  EXPECT_EQ(fault(nodes + "f 1 2 3\nf 2 3 5\nf 1 3 4\n"), "") << "neighbours that disagree are turned over";
}

}  // namespace
}  // namespace unibody::mesh_cloth_test
