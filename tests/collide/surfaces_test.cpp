// Which faces and edges a rank knows of, what lies next to what, and whom it asks for, against all cells of the surfaces.
#include "collide/surfaces.hpp"

#include <gtest/gtest.h>

#include <map>

#include "collide/surface_world.hpp"
#include "scene/scene_text.hpp"

namespace unibody::surfaces_test {
namespace {

using namespace samples;

using Key = std::array<Id, 3>;  // ascending; of a segment two are equal
Key sorted(Key ids) {
  std::sort(ids.begin(), ids.end());
  return ids;
}

// The bodies of a scene that are here, homes and guests by a rule.
struct Part {
  Scene scene;
  World world;
  std::unique_ptr<Surfaces> known;

  template <class IsHome, class IsHere>
  Part(const Scene& of, IsHome is_home, IsHere is_here) : scene(of) {
    std::vector<Body> bodies;
    for (Id id = 0; id < scene.body_count(); ++id)
      if (is_here(id)) bodies.push_back(scene.body(id));
    world = world_of(bodies, [&](Id id) { return !is_home(id); });
    known = std::make_unique<Surfaces>(scene.surfaces);
    known->build(world);
  }
  Id id(Slot s) const { return s < 0 ? -1 : world.id[static_cast<std::size_t>(s)]; }
  bool is_home(Id body) const {
    const Slot s = world.find(body);
    return s >= 0 && world.is_home(s);
  }
};

// Cells whose nodes are all here, by surface, from Surface::cell alone.
std::multimap<Key, std::int32_t> cells_here(const Part& part) {
  std::multimap<Key, std::int32_t> cells;
  for (std::size_t k = 0; k < part.scene.surfaces.size(); ++k) {
    const Surface& s = part.scene.surfaces[k];
    for (Id c = 0; c < s.count; ++c) {
      Key ids = s.cell(c);
      if (s.corners == 2) ids[2] = ids[1];
      if (std::all_of(ids.begin(), ids.end(), [&](Id id) { return part.world.find(id) >= 0; }))
        cells.emplace(sorted(ids), static_cast<std::int32_t>(k));
    }
  }
  return cells;
}

void expect_as_by_brute_force(const Part& part) {
  const auto expected = cells_here(part);
  std::multimap<Key, std::int32_t> found;
  std::map<std::array<Id, 2>, std::multiset<Id>> wings;  // of each edge: the third nodes of its faces
  const Surfaces& known = *part.known;
  for (const SurfaceFace& f : known.faces) {
    const Key ids{part.id(f.nodes[0]), part.id(f.nodes[1]), part.id(f.nodes[2])};
    found.emplace(sorted(ids), f.surface);
    bool home = false;
    for (const Id id : ids) home |= part.is_home(id);
    EXPECT_EQ(f.home, home);
    for (std::size_t i = 0; i < (f.is_segment() ? 1u : 3u); ++i) {
      const Id a = ids[i], b = ids[(i + 1) % 3];
      auto& of_edge = wings[{std::min(a, b), std::max(a, b)}];
      if (!f.is_segment()) of_edge.insert(ids[(i + 2) % 3]);
    }
  }
  ASSERT_EQ(found, expected);

  for (const SurfaceFace& f : known.faces)
    for (std::size_t i = 0; i < (f.is_segment() ? 1u : 3u); ++i) {
      const Id a = part.id(f.nodes[i]), b = part.id(f.nodes[(i + 1) % 3]), own = part.id(f.nodes[(i + 2) % 3]);
      auto others = wings.at({std::min(a, b), std::max(a, b)});
      if (!f.is_segment()) others.erase(others.find(own));
      EXPECT_EQ(part.id(f.across[i]), others.empty() ? -1 : *others.begin());
    }

  std::map<Id, std::multiset<Id>> rings;
  std::set<std::array<Id, 2>> edges;
  for (const SurfaceEdge& e : known.edges) {
    const std::array<Id, 2> ids{part.id(e.nodes[0]), part.id(e.nodes[1])};
    ASSERT_LT(ids[0], ids[1]);
    EXPECT_TRUE(edges.insert(ids).second) << "an edge twice";
    std::multiset<Id> of_edge;
    for (const Slot s : e.wings)
      if (s >= 0) of_edge.insert(part.id(s));
    ASSERT_TRUE(wings.contains(ids));
    EXPECT_EQ(of_edge, wings.at(ids));
    EXPECT_EQ(e.home, part.is_home(ids[0]) || part.is_home(ids[1]));
    rings[ids[0]].insert(ids[1]), rings[ids[1]].insert(ids[0]);
  }
  EXPECT_EQ(edges.size(), wings.size());

  for (Slot s = 0; s < static_cast<Slot>(part.world.size()); ++s) {
    const Id id = part.id(s);
    std::int32_t surface = -1;
    for (std::size_t k = 0; k < part.scene.surfaces.size(); ++k)
      if (const Surface& of = part.scene.surfaces[k]; id >= of.first_node && id < of.first_node + of.node_count)
        surface = static_cast<std::int32_t>(k);
    EXPECT_EQ(known.is_node(s), surface >= 0) << id;
    if (surface < 0) continue;
    EXPECT_EQ(known.surface_of(s), surface);
    std::multiset<Id> ring;
    for (const Slot next : known.ring(s)) ring.insert(part.id(next));
    EXPECT_EQ(ring, rings[id]) << id;
  }
}

// A grid, a mesh of a tetrahedron and a triangle beside it, a thread, and bodies between them.
Scene mixed_scene() {
  const TextFile mesh(
      "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nv 2 1 0\nv 2 2 0\nv 3 1 0\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\nf 5 7 6\n");
  return scene_from(R"(
bodies:
  - {shape: {plane: {normal: [0, 0, 1]}}}
  - {shape: {sphere: {radius: 0.1}}, mass: 1, position: [0, 0, 3]}
cloths:
  - {grid: {size: [1, 1], nodes: [6, 5]}, mass: 1, thickness: 0.01}
  - {mass: 1, thickness: 0.01, self_collision: true, mesh: )" +
                    mesh.path().substr(mesh.path().rfind('/') + 1) + R"(}
threads:
  - {points: [[0, 0, 1], [1, 0, 1]], segments: 6, radius: 0.01, mass: 0.1}
)");
}

// Nodes by cells alone that share one with a node of `from`.
std::set<Id> within_a_face(const Scene& scene, const std::set<Id>& from) {
  std::set<Id> found = from;
  for (const Surface& s : scene.surfaces)
    for (Id c = 0; c < s.count; ++c) {
      const auto ids = s.cell(c);
      const auto end = ids.begin() + s.corners;
      if (std::any_of(ids.begin(), end, [&](Id id) { return from.contains(id); })) found.insert(ids.begin(), end);
    }
  return found;
}

bool contains(const Bounds& outer, const Bounds& inner) {
  return (outer.lower.array() <= inner.lower.array()).all() && (inner.upper.array() <= outer.upper.array()).all();
}

}  // namespace

TEST(Surfaces, FacesEdgesAndNeighboursAreThoseOfAllCells) {
  const Scene scene = mixed_scene();
  expect_as_by_brute_force(Part(
      scene, [](Id) { return true; }, [](Id) { return true; }));
  Random random(1);
  for (int round = 0; round < 40; ++round) {  // on a rank that has some of the bodies, as homes or as guests
    std::vector<int> role(static_cast<std::size_t>(scene.body_count()));
    const double share = random(0, 0.5);
    for (int& r : role) r = random(0, 1) < share ? 0 : random(0, 1) < 0.5 ? 1 : 2;
    const auto of = [&](Id id) { return role[static_cast<std::size_t>(id)]; };
    expect_as_by_brute_force(Part(
        scene, [&](Id id) { return of(id) == 1; }, [&](Id id) { return of(id) > 0; }));
  }
}

TEST(Surfaces, CountsOfAGrid) {
  const Scene scene = scene_from("cloths:\n  - {grid: {size: [1, 1], nodes: [6, 5]}, mass: 1, thickness: 0.01}\n");
  const Part all(
      scene, [](Id) { return true; }, [](Id) { return true; });
  EXPECT_EQ(all.known->faces.size(), 2u * 5 * 4);
  EXPECT_EQ(all.known->edges.size(), 5u * 5 + 6 * 4 + 5 * 4);  // along x, along y, diagonals
  std::size_t boundary = 0;
  for (const SurfaceEdge& e : all.known->edges) boundary += e.wings[1] < 0;
  EXPECT_EQ(boundary, 2u * 5 + 2 * 4);
}

// As the scene says, and not unless it says so. One surface alone has nothing for its edges to meet.
TEST(Surfaces, SelfCollision) {
  for (const std::string kind : {"cloth", "thread"})
    for (const std::string text : {"", ", self_collision: false", ", self_collision: true"}) {
      const Scene scene = scene_from(
          kind == "cloth" ? "cloths:\n  - {grid: {size: [1, 1], nodes: [3, 3]}, mass: 1, thickness: 0.01" + text + "}\n"
                          : "threads:\n  - {points: [[0, 0, 0], [1, 0, 0]], segments: 3, radius: 0.01, mass: 1" + text + "}\n");
      const bool itself = text.find("true") != std::string::npos;
      ASSERT_EQ(scene.surfaces.size(), 1u);
      EXPECT_EQ(scene.surfaces[0].self_collision, itself) << kind << text;
      const Part part(
          scene, [](Id) { return true; }, [](Id) { return true; });
      EXPECT_EQ(part.known->edges_may_meet(), itself);
      EXPECT_EQ(part.known->contact_group(part.world, 0), itself ? -1 : part.world.properties[0].group);
      EXPECT_GE(part.world.properties[0].group, 0);
    }
  const Part mixed(
      mixed_scene(), [](Id) { return true; }, [](Id) { return true; });
  EXPECT_TRUE(mixed.known->edges_may_meet());
}

// Those within two faces; and wanting is mutual, whoever has what.
TEST(Surfaces, PartnersAreNodesWithinTwoFaces) {
  const Scene scene = mixed_scene();
  Random random(2);
  for (int round = 0; round < 20; ++round) {
    const int ranks = 2 + round % 3;
    std::vector<int> rank(static_cast<std::size_t>(scene.body_count()));
    for (int& r : rank) r = static_cast<int>(random(0, ranks));
    std::vector<std::set<Id>> wanted;
    for (int r = 0; r < ranks; ++r) {
      const auto here = [&](Id id) { return id == 0 || rank[static_cast<std::size_t>(id)] == r; };  // the plane is everywhere
      const Part part(scene, here, here);
      std::set<Id> homes;
      for (Id id = 1; id < scene.body_count(); ++id)
        if (here(id)) homes.insert(id);
      std::set<Id> expected;
      for (const Id id : within_a_face(scene, within_a_face(scene, homes)))
        if (!here(id)) expected.insert(id);
      const std::vector<Id> found = part.known->partners(part.world);
      EXPECT_EQ(found, std::vector<Id>(expected.begin(), expected.end()));
      wanted.push_back(expected);
    }
    for (int a = 0; a < ranks; ++a)
      for (int b = 0; b < ranks; ++b) {
        const auto wants = [&](int who, int of) {
          return std::any_of(wanted[static_cast<std::size_t>(who)].begin(), wanted[static_cast<std::size_t>(who)].end(),
                             [&](Id id) { return rank[static_cast<std::size_t>(id)] == of; });
        };
        EXPECT_EQ(wants(a, b), wants(b, a));
      }
  }
}

// The bounds of a home node hold all that its faces sweep, a step back and a step ahead, and half of their extent beyond; those
// of bodies stay.
TEST(Surfaces, WidenedBoundsHoldWhatFacesSweep) {
  Part part(
      mixed_scene(), [](Id id) { return id % 3 != 0; }, [](Id) { return true; });
  Random random(3);
  CollideSettings settings;
  settings.gravity = Vec3(0, 0, -9.81);
  int grown = 0;
  for (int round = 0; round < 20; ++round) {
    const double speed = std::pow(10, random(-1, 2));
    for (Vec3& v : part.world.velocity) v = speed * random.vector(-1, 1);
    settings.has_past = round % 2;
    std::vector<Bounds> before(part.world.homes);
    for (std::size_t i = 0; i < before.size(); ++i) before[i] = swept_bounds(part.world, i, settings);
    std::vector<Bounds> after = before;
    part.known->widen(part.world, settings, after);
    for (std::size_t i = 0; i < before.size(); ++i) {
      EXPECT_TRUE(contains(after[i], before[i]));
      if (!part.known->is_node(static_cast<Slot>(i))) {
        EXPECT_TRUE(contains(before[i], after[i]));
      }
    }
    for (const SurfaceFace& f : part.known->faces) {
      Bounds swept = swept_bounds(part.world, f.nodes, settings);
      Vec3 low = Vec3::Constant(HUGE_VAL), high = -low;
      for (const Slot s : f.nodes) {
        const Vec3& x = part.world.position[static_cast<std::size_t>(s)];
        low = low.cwiseMin(x), high = high.cwiseMax(x);
      }
      EXPECT_EQ(surface_slack(part.world, f.nodes), (high - low).maxCoeff() / 2);
      const double slack = (high - low).maxCoeff() / 2;
      swept.lower.array() -= slack, swept.upper.array() += slack;
      for (const Slot s : f.nodes)
        if (part.world.is_home(s)) {
          EXPECT_TRUE(contains(after[static_cast<std::size_t>(s)], swept));
          grown += !contains(before[static_cast<std::size_t>(s)], swept);
        }
    }
  }
  EXPECT_GT(grown, 1000);
}

// By its height over the line between its wings: more than a tenth of the radius. Boundaries are always sharp, and so is what is
// folded back.
TEST(Surfaces, SharpEdges) {
  const double r = 0.02;
  const auto sharp = [&](const Vec3& first, const Vec3& second, bool boundary) {
    SurfaceWorld s;
    Cells cells{{0, 1, 2}, {1, 0, 3}};
    if (boundary) cells.pop_back();
    s.add_surface({{0, -1, 0}, {0, 1, 0}, first, second}, cells, r);
    Random random(4);
    const Mat3 turn = random.turn().toRotationMatrix();
    for (Body& b : s.bodies) b.state.position = turn * b.state.position;
    s.build();
    for (const SurfaceEdge& e : s.known->edges)
      if (e.nodes[0] == 0 && e.nodes[1] == 1) return is_sharp(s.world, e);
    ADD_FAILURE() << "no such edge";
    return false;
  };
  EXPECT_FALSE(sharp({1, 0, 0}, {-1, 0.3, 0}, false)) << "flat";
  EXPECT_TRUE(sharp({1, 0, 0}, {-1, 0.3, 0}, true)) << "boundary";
  for (const double side : {1.0, -1.0}) {
    EXPECT_FALSE(sharp({1, 0, side * 0.099 * r}, {-1, 0, side * 0.099 * r}, false));
    EXPECT_TRUE(sharp({1, 0, side * 0.101 * r}, {-1, 0, side * 0.101 * r}, false));
    EXPECT_TRUE(sharp({0.5, 0, side * 0.06 * r}, {-1, 0, side * 0.2 * r}, false));  // the line passes at (0.06 + 0.07 / 1.5) r
    EXPECT_FALSE(sharp({0.5, 0, 0}, {-1, 0, side * 0.2 * r}, false));               // at 0.2 / 3 r
  }
  EXPECT_TRUE(sharp({1, 0, 0}, {1, 0, 0}, false)) << "folded flat";
  EXPECT_TRUE(sharp({1, 0, 0}, {0.7, 0.2, 1e-4}, false)) << "nearly so";
}

}  // namespace unibody::surfaces_test
