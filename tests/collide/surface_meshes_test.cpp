// Which nodes and edges of a mesh touch the faces of a surface, how often, and from which side.
#include <gtest/gtest.h>

#include "collide/surface_contacts.hpp"
#include "collide/surface_world.hpp"
#include "world/shape_library.hpp"

namespace unibody::samples::surface_meshes_test {

namespace {

constexpr double radius = 0.005;  // m, of nodes

using Triangles = std::vector<std::array<std::int32_t, 3>>;

Body fixed_mesh(const MeshSurface& mesh) {
  const Shape shape = shape_library().add(mesh);
  Body b = body(0, shape.kind, shape.size, Vec3::Zero(), Motion::fixed);
  b.properties.shape = shape;
  return b;
}

// A pyramid with its tip there.
Body with_tip(const Vec3& tip) {
  const std::vector<Vec3> nodes{tip + Vec3(-.1, -.1, -.4), tip + Vec3(.1, -.1, -.4), tip + Vec3(.1, .1, -.4),
                                tip + Vec3(-.1, .1, -.4), tip};
  return fixed_mesh(make_mesh_shape(nodes, Triangles{{0, 2, 1}, {0, 3, 2}, {0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}}));
}

Body block(const Vec3& half) {
  std::vector<Vec3> nodes;
  for (int k = 0; k < 8; ++k) nodes.push_back(half.cwiseProduct(Vec3(k & 1 ? 1 : -1, k & 2 ? 1 : -1, k & 4 ? 1 : -1)));
  return fixed_mesh(make_mesh_shape(nodes, Triangles{{0, 2, 3},
                                                     {0, 3, 1},
                                                     {4, 5, 7},
                                                     {4, 7, 6},
                                                     {0, 1, 5},
                                                     {0, 5, 4},
                                                     {2, 6, 7},
                                                     {2, 7, 3},
                                                     {0, 4, 6},
                                                     {0, 6, 2},
                                                     {1, 3, 7},
                                                     {1, 7, 5}}));
}

// The sheet lies in the plane z = 0, its nodes 0.5 m apart; id 0 is the mesh.
Contacts under_a_sheet(const Body& mesh) {
  SurfaceWorld s;
  s.add(mesh);
  const Sheet flat = sheet(5, 5, 2, 2);
  s.add_surface(flat.nodes, flat.cells, radius);
  return s.contacts();
}

}  // namespace

// Over a tip, or with it through by less than it is told to come back from: four triangles of the mesh share it, and one or two
// faces of the sheet, or six.
TEST(SurfaceMeshes, ATipIsOneContact) {
  for (const Vec3& at : {Vec3(.13, .37, 0), Vec3(.25, .25, 0), Vec3(.5, .2, 0)})
    for (const double up : {-0.006, -0.004, 0.0, 0.002, 0.015}) {
      SCOPED_TRACE(std::to_string(at.x()) + ", " + std::to_string(up));
      if (up == 0 && at.y() != .37) continue;  // at the same place on an edge: the next step knows
      const Contacts found = under_a_sheet(with_tip(at + Vec3(0, 0, up)));
      ASSERT_EQ(found.surface.size(), 1u);
      EXPECT_LT((found.surface[0].normal + Vec3::UnitZ()).norm(), 1e-12);
      EXPECT_NEAR(found.surface[0].gap, -up - radius, 1e-14);
      EXPECT_TRUE(found.points.empty());
    }
  EXPECT_TRUE(under_a_sheet(with_tip({.13, .37, -0.009})).surface.empty()) << "further off than the margin";
  EXPECT_TRUE(under_a_sheet(with_tip({.13, .37, 0.021})).surface.empty()) << "all but past it";
}

// 8 mm thick: the far side, and its rim, are no deeper behind the sheet than what is told to come back.
TEST(SurfaceMeshes, APlateTouchesEachSheetFromItsOwnSide) {
  for (const double side : {-1, 1}) {
    const double half = 0.004;
    const Body plate = block({.33, .37, half});
    Body moved = plate;
    moved.state.position = Vec3(.03, .02, -side * (half + radius + 0.0005));
    const Contacts found = under_a_sheet(moved);
    EXPECT_GT(found.surface.size(), 10u);
    for (const SurfaceContact& c : found.surface) {
      EXPECT_LT((c.normal + side * Vec3::UnitZ()).norm(), 1e-12);
      EXPECT_NEAR(c.gap, 0.0005, 1e-14);
    }
  }
}

// Its four corners and its rim, which is crossed by the sheet's edges: each once. The diagonals of its faces are flat.
TEST(SurfaceMeshes, ABlockTouchesWithItsCornersAndRim) {
  const Vec3 half(.33, .37, .2);
  Body b = block(half);
  b.state.position = Vec3(.03, .02, -half.z() - radius);
  SurfaceWorld s;
  s.add(b);
  const Sheet flat = sheet(5, 5, 2, 2);
  s.add_surface(flat.nodes, flat.cells, radius);
  std::set<std::array<Id, 3>> edges;  // of the sheet, and the side of the rim that they cross
  for (const auto& cell : flat.cells)
    for (std::size_t k = 0; k < 3; ++k) {
      const Id p = std::min(cell[k], cell[(k + 1) % 3]), q = std::max(cell[k], cell[(k + 1) % 3]);
      const Vec3 from = flat.nodes[std::size_t(p)] - b.state.position, to = flat.nodes[std::size_t(q)] - b.state.position;
      for (Id side = 0; side < 4; ++side) {
        const Eigen::Index axis = side / 2, other = 1 - axis;
        const double at = side % 2 ? half[axis] : -half[axis], share = (at - from[axis]) / (to[axis] - from[axis]);
        const double place = from[other] + share * (to[other] - from[other]);
        if (share > 0 && share < 1 && std::abs(place) < half[other]) edges.insert({p, q, side});
      }
    }
  std::size_t corners = 0, crossed = 0;
  for (const SurfaceContact& c : s.contacts().surface) {
    EXPECT_LT((c.normal + Vec3::UnitZ()).norm(), 1e-12);
    EXPECT_NEAR(c.gap, 0, 1e-14);
    (c.ids[3] < 0 ? crossed : corners) += 1;
  }
  EXPECT_EQ(corners, 4u);
  EXPECT_EQ(crossed, edges.size());
}

// Nodes say all there is to say of a level ground, however finely it is cut.
TEST(SurfaceMeshes, LevelGroundIsLeftToTheNodes) {
  const Sheet ground = sheet(21, 21, 3, 3);
  Triangles triangles;
  for (const auto& c : ground.cells)
    triangles.push_back({static_cast<std::int32_t>(c[0]), static_cast<std::int32_t>(c[1]), static_cast<std::int32_t>(c[2])});
  Body level = fixed_mesh(make_mesh_shape(ground.nodes, triangles, 1));
  level.state.position = Vec3(.03, .02, -radius);
  const Contacts found = under_a_sheet(level);
  EXPECT_TRUE(found.surface.empty());
  EXPECT_GE(found.manifolds.size(), 25u);
}

}  // namespace unibody::samples::surface_meshes_test
