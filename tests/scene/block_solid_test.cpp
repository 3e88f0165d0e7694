// Blocks of tetrahedra: their volume, surface, masses, colours, and the parts that loads and pins name.
#include <algorithm>
#include <map>
#include <set>

#include "scene/scene_text.hpp"
#include "small_worlds.hpp"

namespace unibody::block_solid_test {
namespace {

constexpr Id nx = 3, ny = 2, nz = 4;  // cells
const Vec3 size(0.6, 0.5, 0.9);       // m

std::string block(const std::string& more = "") {
  return "solids:\n  - block: {size: [0.6, 0.5, 0.9], cells: [3, 2, 4]}\n    density: 800\n    youngs_modulus: 1.0e5\n"
         "    poissons_ratio: 0.3\n    thickness: 0.01\n    position: [0, 0, 3]\n" +
         more;
}

Scene solid(const std::string& more = "") { return small_worlds::scene_from_text(block(more)); }

Vec3 place(const Scene& scene, Id id) { return scene.body(id).state.position; }

double volume_of(const Scene& scene, const std::array<Id, 4>& ids) {
  const Vec3 a = place(scene, ids[0]);
  return (place(scene, ids[1]) - a).dot((place(scene, ids[2]) - a).cross(place(scene, ids[3]) - a)) / 6;
}

// The one of a cell's five that has no corner's right angles: its edges are the diagonals of the cell's faces.
bool is_central(const Scene& scene, const std::array<Id, 4>& ids) {
  int sides = 0;  // edges along an axis
  for (std::size_t a = 0; a < 4; ++a)
    for (std::size_t b = 0; b < a; ++b)
      sides += ((place(scene, ids[a]) - place(scene, ids[b])).array().abs() < 1e-12).count() == 2;
  return sides == 0;
}

// All of a type, each as often as its nodes ask for it.
template <class C>
std::map<std::array<Id, 4>, std::vector<Constraint<C>>> constraints_of(const Scene& scene) {
  std::map<std::array<Id, 4>, std::vector<Constraint<C>>> result;
  for (Id id = 0; id < scene.body_count(); ++id) {
    ConstraintSet set;
    scene.constraint_groups[0].touching(id, set);
    for (const auto& c : std::get<ConstraintList<C>>(set)) {
      EXPECT_NE(std::find(c.ids.begin(), c.ids.end(), id), c.ids.end());
      result[c.ids].push_back(c);
    }
  }
  return result;
}

TEST(BlockSolid, TetrahedraFillTheBlockAndAreAtRest) {
  const Scene scene = solid("    least_volume: 0.2\n");
  ASSERT_EQ(scene.body_count(), (nx + 1) * (ny + 1) * (nz + 1));
  const auto tets = constraints_of<Tetrahedron>(scene);
  ASSERT_EQ(tets.size(), 5u * nx * ny * nz);
  double total = 0;
  for (const auto& [ids, each] : tets) {
    EXPECT_EQ(each.size(), 4u);  // once from each of its nodes
    const double volume = volume_of(scene, ids);
    EXPECT_NEAR(volume, (is_central(scene, ids) ? 2 : 1) * size.prod() / (6 * nx * ny * nz), 1e-15);
    total += volume;
    std::array<Vec4d, 10> p;
    std::array<Vec3x4, 4> x;
    for (std::size_t k = 0; k < 10; ++k) p[k] = broadcast(each[0].parameters[k]);
    for (std::size_t e = 0; e < 4; ++e) {
      const Vec3 at = place(scene, ids[e]);
      x[e] = {broadcast(at.x()), broadcast(at.y()), broadcast(at.z())};
    }
    Rows<4, 6> rows;
    Tetrahedron::evaluate(p, x, rows);
    for (const Vec4d& value : rows.value) EXPECT_NEAR(value[0], 0, 1e-13);
  }
  EXPECT_NEAR(total, size.prod(), 1e-13);
  EXPECT_EQ(constraints_of<InversionGuard>(scene).size(), tets.size());
  EXPECT_TRUE(constraints_of<InversionGuard>(solid()).empty());
}

TEST(BlockSolid, NeighboursShareFacesAndTheRestIsTheSurface) {
  const Scene scene = solid();
  std::map<std::set<Id>, std::vector<std::array<Id, 3>>> faces;  // of tetrahedra, outward
  for (const auto& [n, each] : constraints_of<Tetrahedron>(scene))
    for (const auto& f : {std::array{n[1], n[2], n[3]}, {n[0], n[3], n[2]}, {n[0], n[1], n[3]}, {n[0], n[2], n[1]}})
      faces[{f[0], f[1], f[2]}].push_back(f);
  const auto turned_to_lowest = [](std::array<Id, 3> f) {
    std::rotate(f.begin(), std::min_element(f.begin(), f.end()), f.end());
    return f;
  };
  std::set<std::array<Id, 3>> outer, surface;
  for (const auto& [nodes, sides] : faces) {
    ASSERT_LE(sides.size(), 2u);
    if (sides.size() == 1) outer.insert(turned_to_lowest(sides[0]));
  }
  ASSERT_EQ(scene.surfaces.size(), 1u);
  for (Id t = 0; t < scene.surfaces[0].count; ++t) surface.insert(turned_to_lowest(scene.surfaces[0].cell(t)));
  EXPECT_EQ(static_cast<Id>(surface.size()), scene.surfaces[0].count);
  EXPECT_EQ(surface, outer);
  std::map<std::array<Id, 3>, int> asked;
  for (Id id = 0; id < scene.body_count(); ++id) {
    std::vector<std::array<Id, 3>> at;
    scene.surfaces[0].cells_of(id, at);
    for (const auto& f : at) {
      EXPECT_NE(std::find(f.begin(), f.end(), id), f.end());
      ++asked[turned_to_lowest(f)];
    }
  }
  ASSERT_EQ(asked.size(), surface.size());
  for (const auto& [face, times] : asked) EXPECT_EQ(times, 3);
}

TEST(BlockSolid, ANodeHasAnEighthOfEachOfItsCells) {
  const Scene scene = solid();
  double whole = 0;
  for (Id id = 0; id < scene.body_count(); ++id) {
    double mass = 800 * size.prod() / (nx * ny * nz);
    for (Eigen::Index k = 0; k < 3; ++k)
      if (std::abs(std::abs((place(scene, id) - Vec3(0, 0, 3))[k]) - size[k] / 2) < 1e-12) mass /= 2;  // on a side
    EXPECT_NEAR(scene.body(id).properties.mass, mass, 1e-12);
    whole += mass;
  }
  EXPECT_NEAR(whole, 800 * size.prod(), 1e-9);
}

// An even number of cells along an axis: mirrored there, each tetrahedron is one of the block's.
TEST(BlockSolid, IsItsOwnMirrorImage) {
  const Scene scene = small_worlds::scene_from_text(
      "solids:\n  - block: {size: [0.6, 0.5, 0.9], cells: [3, 2, 4]}\n    density: 800\n    youngs_modulus: 1.0e5\n"
      "    poissons_ratio: 0.3\n    thickness: 0.01\n");
  std::set<std::set<Id>> all;
  for (const auto& [ids, each] : constraints_of<Tetrahedron>(scene)) all.insert({ids.begin(), ids.end()});
  const std::array<Id, 3> nodes{nx + 1, ny + 1, nz + 1};
  for (const std::size_t axis : {std::size_t{1}, std::size_t{2}}) {
    for (const auto& tet : all) {
      std::set<Id> image;
      for (const Id id : tet) {
        std::array<Id, 3> at{id % nodes[0], id / nodes[0] % nodes[1], id / (nodes[0] * nodes[1])};
        at[axis] = nodes[axis] - 1 - at[axis];
        image.insert(at[0] + nodes[0] * (at[1] + nodes[1] * at[2]));
      }
      EXPECT_TRUE(all.contains(image)) << axis;
    }
  }
}

TEST(BlockSolid, TwoOfAColourShareNoNode) {
  const Scene scene = solid("    least_volume: 0.2\n");
  std::set<std::pair<std::int32_t, Id>> taken;
  for (const auto& [ids, each] : constraints_of<Tetrahedron>(scene))
    for (const Id id : ids) EXPECT_TRUE(taken.emplace(each[0].colour, id).second);
}

TEST(BlockSolid, ComplianceIsThatOfTheModuli) {
  const auto tets = constraints_of<Tetrahedron>(solid());
  for (const auto& [ids, each] : tets) {
    const double length = each[0].parameters[9], volume = volume_of(solid(), ids);
    EXPECT_NEAR(length, std::cbrt(6 * volume), 1e-14);
    const double bulk = 1e5 / (3 * (1 - 2 * 0.3)), shear = 1e5 / (2 * (1 + 0.3));
    EXPECT_NEAR(each[0].compliance[0], length * length / (volume * 3 * bulk), 1e-18);
    for (std::size_t k = 1; k < 6; ++k) EXPECT_NEAR(each[0].compliance[k], length * length / (volume * 2 * shear), 1e-18);
  }
}

// Of a uniform pressure on the upper face each node has its share of the area.
TEST(BlockSolid, LoadsAreSpreadByArea) {
  const Scene scene = solid("    loads:\n      - {within: {min: [-1, -1, 3.45], max: [1, 1, 4]}, force: [1, 2, -30]}\n");
  Vec3 sum = Vec3::Zero(), moment = Vec3::Zero();
  for (Id id = 0; id < scene.body_count(); ++id) {
    const Body body = scene.body(id);
    sum += body.properties.force;
    moment += (body.state.position - Vec3(0, 0, 3)).cross(body.properties.force);
    if (body.state.position.z() < 3.44) {
      EXPECT_EQ(body.properties.force.norm(), 0);
    }
  }
  EXPECT_LT((sum - Vec3(1, 2, -30)).norm(), 1e-12);
  EXPECT_LT((moment - Vec3(0, 0, 0.45).cross(Vec3(1, 2, -30))).norm(), 1e-12);  // through the middle of the face
}

TEST(BlockSolid, PinsHoldAllNodesOfAPart) {
  const Scene scene = solid("    pins: [{within: {min: [-1, -1, 2.5], max: [1, 1, 2.6]}, release: 2}]\n");
  std::set<Id> held, expected;
  for (const Pin& pin : scene.pins) held.insert(pin.id);
  for (Id id = 0; id < scene.body_count(); ++id)
    if (place(scene, id).z() < 2.6) expected.insert(id);
  EXPECT_EQ(held, expected);
  EXPECT_EQ(held.size(), static_cast<std::size_t>((nx + 1) * (ny + 1)));
}

TEST(BlockSolid, SpinTurnsAboutThePosition) {
  const Scene scene = solid("    velocity: [1, 0, 0]\n    angular_velocity: [0, 0, 2]\n");
  for (Id id = 0; id < scene.body_count(); ++id) {
    const BodyState state = scene.body(id).state;
    EXPECT_LT((state.velocity - Vec3(1, 0, 0) - Vec3(0, 0, 2).cross(state.position - Vec3(0, 0, 3))).norm(), 1e-14);
  }
}

// By centroid, in world axes: the block is turned upside down.
TEST(BlockSolid, RegionsHaveTheirOwnModulus) {
  const Scene scene = solid(
      "    orientation: {axis: [1, 0, 0], angle: 180}\n"
      "    regions: [{within: {min: [-1, -1, 3], max: [1, 1, 4]}, youngs_modulus: 3.0e+7, damping: 0.1}]\n");
  for (const auto& [ids, each] : constraints_of<Tetrahedron>(scene)) {
    double height = 0;
    for (const Id id : ids) height += place(scene, id).z() / 4;
    const double length = each[0].parameters[9], volume = volume_of(scene, ids);
    const double E = height > 3 ? 3e7 : 1e5;
    EXPECT_NEAR(each[0].compliance[1], 1.3 * length * length / (volume * E), 1e-12 / E);
    EXPECT_EQ(each[0].damping, height > 3 ? 0.1 : 0.0);
  }
}

// A mesh may have several parts: one is held, and the other one, which has nothing to do with it, falls freely.
TEST(MeshSolid, TwoPartsAreTwoBodies) {
  const TextFile file(
      "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n8\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n5 5 0 0\n6 6 0 0\n7 5 1 0\n"
      "8 5 0 1\n$EndNodes\n$Elements\n2\n1 4 2 1 1 1 2 3 4\n2 4 2 1 1 5 6 7 8\n$EndElements\n",
      ".msh");
  small_worlds::Experiment run(
      scene_from("solids:\n  - mesh: " + file.path().substr(file.path().rfind('/') + 1) +
                 "\n    density: 1000\n    youngs_modulus: 1.0e+5\n    poissons_ratio: 0.3\n    thickness: 0.01\n"
                 "    pins: [{within: {min: [-1, -1, -1], max: [2, 2, 2]}}]\n"));
  ASSERT_EQ(run.world().homes, 8u);
  const std::vector<Vec3> start = run.world().position;
  run.steps(20);
  for (Id id = 0; id < 8; ++id) {
    const double fallen = id < 4 ? 0 : 9.81 * run.h() * run.h() * 20 * 21 / 2;
    EXPECT_LT((run.position(id) - start[run.slot(id)] + Vec3(0, 0, fallen)).norm(), 1e-12) << id;
  }
}

}  // namespace
}  // namespace unibody::block_solid_test
