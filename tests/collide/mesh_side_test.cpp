// Which side of a mesh a point is on, against all triangles and closed forms; and that bodies behind a mesh are pushed out of it.
#include "collide/mesh_side.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "collide/bodies.hpp"
#include "collide/triangle_distance.hpp"
#include "world/shape_library.hpp"

namespace unibody::samples::mesh_side_test {

namespace {

using Triangles = std::vector<std::array<std::int32_t, 3>>;

constexpr int cells = 8;
constexpr double width = 2;  // m

double height(double x, double y) { return 0.3 * std::sin(5 * x + 1) * std::cos(4 * y); }

// Steep hills of 8 x 8 cells; nodes at the heights above.
MeshSurface hills(double below) {
  std::vector<Vec3> nodes;
  Triangles triangles;
  for (int j = 0; j <= cells; ++j)
    for (int i = 0; i <= cells; ++i) {
      const double x = width * i / cells - 1, y = width * j / cells - 1;
      nodes.emplace_back(x, y, height(x, y));
    }
  for (int j = 0; j < cells; ++j)
    for (int i = 0; i < cells; ++i) {
      const int a = i + (cells + 1) * j, b = a + 1, c = a + cells + 1, d = c + 1;
      triangles.push_back({a, b, d}), triangles.push_back({a, d, c});
    }
  return make_mesh_shape(nodes, triangles, below);
}

// A block of half lengths 0.5, 0.3, 0.1 about the origin, outwards or as a cavity.
MeshSurface block(bool inwards) {
  std::vector<Vec3> nodes;
  for (int k = 0; k < 8; ++k) nodes.emplace_back(k & 1 ? 0.5 : -0.5, k & 2 ? 0.3 : -0.3, k & 4 ? 0.1 : -0.1);
  Triangles triangles{{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                      {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  if (inwards)
    for (auto& t : triangles) std::swap(t[1], t[2]);
  return make_mesh_shape(nodes, triangles);
}

// A ring of radius 0.6 and thickness 0.5 about the z axis, outwards or as a cavity.
MeshSurface ring(bool inwards) {
  constexpr int around = 48, across = 24;
  std::vector<Vec3> nodes;
  Triangles triangles;
  for (int j = 0; j < around; ++j)
    for (int i = 0; i < across; ++i) {
      const double turn = 2 * M_PI * j / around, roll = 2 * M_PI * i / across, radius = 0.6 + 0.25 * std::cos(roll);
      nodes.emplace_back(radius * std::cos(turn), radius * std::sin(turn), 0.25 * std::sin(roll));
      const int next = (j + 1) % around * across, k = (i + 1) % across, a = j * across + i, b = next + i, c = next + k;
      triangles.push_back({a, b, c}), triangles.push_back({a, c, j * across + k});
      if (inwards)
        std::swap(triangles.end()[-1][1], triangles.end()[-1][2]), std::swap(triangles.end()[-2][1], triangles.end()[-2][2]);
    }
  return make_mesh_shape(nodes, triangles);
}

// m, over the point of the mesh with the same x and y.
double height_over(const MeshSurface& mesh, const Vec3& x) {
  for (const auto& t : mesh.triangles) {
    const auto node = [&](int k) { return mesh.nodes[static_cast<std::size_t>(t.nodes[static_cast<std::size_t>(k)])]; };
    bool within = true;
    for (int k = 0; k < 3; ++k) {
      const Vec3 p = node(k), q = node((k + 1) % 3);
      within &= (q.x() - p.x()) * (x.y() - p.y()) - (q.y() - p.y()) * (x.x() - p.x()) >= 0;
    }
    if (within) return t.normal.dot(x - node(0)) / t.normal.z();
  }
  ADD_FAILURE();
  return 0;
}

Body mesh_body(Id id, MeshSurface mesh) {
  Body b = body(id, ShapeKind::mesh, Vec3::Zero(), Vec3::Zero(), Motion::fixed);
  b.properties.shape = shape_library().add(std::move(mesh));
  return b;
}

std::vector<Shape> solids() {
  const std::vector<Vec3> points{{0.1, 0, 0}, {-0.1, 0, 0}, {0, 0.08, 0}, {0, -0.08, 0}, {0, 0, 0.09}, {0, 0, -0.05}};
  return {{ShapeKind::sphere, {0.06, 0, 0}},         {ShapeKind::particle, {0.03, 0, 0}},
          {ShapeKind::box, {0.08, 0.06, 0.04}},      {ShapeKind::capsule, {0.04, 0.04, 0.1}},
          {ShapeKind::cylinder, {0.05, 0.05, 0.06}}, shape_library().add(make_hull(points))};
}

}  // namespace

// The distance is that of the nearest of all triangles, the side that of the height.
TEST(MeshSide, OfHillsIsThatOfTheHeightAndOfAllTriangles) {
  const MeshSurface mesh = hills(1);
  Random random(3);
  int behind = 0, edges = 0;
  for (int trial = 0; trial < 4000; ++trial) {
    const Vec3 x = random.vector(-0.9, 0.9);
    double nearest = HUGE_VAL;
    unsigned feature = 0;
    for (const auto& t : mesh.triangles) {
      const auto node = [&](std::size_t k) { return mesh.nodes[static_cast<std::size_t>(t.nodes[k])]; };
      const TrianglePoint at = closest_on_triangle(x, node(0), node(1), node(2));
      if (at.distance < nearest) nearest = at.distance, feature = at.feature();
    }
    MeshPlace place;
    if (!find_place(mesh, x, HUGE_VAL, place)) continue;  // over the border
    EXPECT_EQ(place.depth > 0, height_over(mesh, x) < 0) << x.transpose();
    EXPECT_NEAR(std::abs(place.depth), nearest, 1e-12);
    EXPECT_NEAR((place.point - x).norm(), nearest, 1e-12);
    behind += place.depth > 0, edges += feature != 7;
    EXPECT_FALSE(find_place(mesh, x, 0.99 * nearest, place));
  }
  EXPECT_GT(behind, 1000);
  EXPECT_GT(edges, 500);
}

TEST(MeshSide, OfABlockIsThatOfItsClosedForm) {
  for (const bool inwards : {false, true}) {
    const MeshSurface mesh = block(inwards);
    EXPECT_TRUE(mesh.is_solid);
    Random random(5);
    for (int trial = 0; trial < 2000; ++trial) {
      const Vec3 x = random.vector(-0.8, 0.8), out = x.cwiseAbs() - Vec3(0.5, 0.3, 0.1);
      const double signed_distance = out.cwiseMax(0).norm() + std::min(out.maxCoeff(), 0.0);
      MeshPlace place;
      ASSERT_TRUE(find_place(mesh, x, HUGE_VAL, place));
      EXPECT_NEAR(place.depth, inwards ? signed_distance : -signed_distance, 1e-12) << x.transpose();
    }
  }
}

// By the grid of cells in front, which fills as places are asked about, the answer is that of the nearest point, in the cells as
// between them and around the grid.
TEST(MeshSide, WhatIsRememberedOfCellsChangesNoAnswer) {
  for (const bool inwards : {false, true}) {
    const MeshSurface mesh = ring(inwards);
    Random random(9);
    int behind = 0, asked = 0;
    for (int trial = 0; trial < 40000; ++trial) {
      Vec3 x = random.vector(-1, 1);
      if (trial % 2 == 0) x.z() *= 0.3;
      if (trial % 100 == 0) x *= 3;
      MeshPlace place, of_behind;
      ASSERT_TRUE(find_place(mesh, x, HUGE_VAL, place));
      ASSERT_EQ(is_behind(mesh, x, HUGE_VAL, of_behind), place.depth > 0) << x.transpose();
      if (place.depth > 0) {
        EXPECT_EQ(of_behind.point, place.point);
      }
      EXPECT_EQ(is_behind(mesh, x, 0.1, of_behind), place.depth > 0 && place.depth <= 0.1) << x.transpose();
      behind += place.depth > 0, ++asked;
    }
    EXPECT_GT(std::min(behind, asked - behind), 4000);
    EXPECT_GT(std::ranges::count(mesh.front_cells.cells, MeshSurface::FrontCells::Cell::in_front), 1000);
  }
  const MeshSurface mesh = block(false);
  const Vec3 nowhere = Vec3::Constant(std::numeric_limits<double>::quiet_NaN());
  MeshPlace place, of_behind;
  const bool is_found = find_place(mesh, nowhere, HUGE_VAL, place);
  EXPECT_EQ(is_behind(mesh, nowhere, HUGE_VAL, of_behind), is_found && place.depth > 0);
}

// However deep the centre is, and whatever the speed: one manifold, along the way to the nearest point of the surface, as deep as
// that and the body's own depth below its centre. The body is in one case the first, in the other the second of the pair.
TEST(MeshSide, BodiesBehindItArePushedToTheNearestPointOfTheSurface) {
  const Body ground = mesh_body(1, hills(1));
  const MeshSurface& mesh = shape_library().meshes[ground.properties.shape.data];
  Random random(7);
  int tried = 0;
  for (const Shape& shape : solids())
    for (int trial = 0; trial < 200; ++trial) {
      Body b = body(trial % 2 == 0 ? 0 : 2, shape.kind, shape.size, Vec3(random(-0.6, 0.6), random(-0.6, 0.6), 0));
      b.properties.shape = shape;
      if (!is_round(shape)) b.state.orientation = random.turn();
      b.state.position.z() -= height_over(mesh, b.state.position) + random(1e-4, 1);
      b.state.velocity = random.vector(-1, 1) * random(0, 10);
      MeshPlace place;
      ASSERT_TRUE(find_place(mesh, b.state.position, HUGE_VAL, place));
      const Pair p = collide_two(b, ground, {});
      const Vec3 way = (place.point - b.state.position) / place.depth, normal = b.id == 0 ? p.normal : Vec3(-p.normal);
      ASSERT_FALSE(p.points.empty()) << static_cast<int>(shape.kind) << trial;
      EXPECT_LT((normal - way).norm(), 1e-6) << static_cast<int>(shape.kind) << trial;
      EXPECT_LT(p.smallest_gap(), -place.depth - 0.02) << static_cast<int>(shape.kind) << trial;
      ++tried;
    }
  EXPECT_EQ(tried, 1200);
}

// A thin plate that is closed: from neither side a body feels the other.
TEST(MeshSide, BodiesOnAThinPlateDoNotFeelItsOtherSide) {
  std::vector<Vec3> nodes;
  MeshSurface thin = block(false);
  for (Vec3& x : thin.nodes) nodes.emplace_back(x.x(), x.y(), 0.02 * x.z());  // 4 mm thick
  Triangles triangles;
  for (const auto& t : thin.triangles) triangles.push_back(t.nodes);
  const Body plate = mesh_body(1, make_mesh_shape(nodes, triangles));
  for (const double side : {1.0, -1.0})
    for (const Shape& shape : solids()) {
      Body b = body(0, shape.kind, shape.size, Vec3(0.02, 0.01, 0));
      b.properties.shape = shape;
      const double reach = bounding_half_extents(shape, Mat3(Mat3::Identity())).z();
      b.state.position.z() = side * (0.9 * reach + 0.002);
      if (shape.kind == ShapeKind::hull && side > 0) b.state.position.z() = 0.05;
      const Contacts c = contacts_of(world_of({b, plate}), {});
      ASSERT_FALSE(c.manifolds.empty()) << static_cast<int>(shape.kind);
      for (const Manifold& m : c.manifolds) EXPECT_GT(side * m.normal.z(), 0.99) << static_cast<int>(shape.kind) << side;
    }
}

// An open sheet has a back: what is far behind it is left alone, and so is what is beyond its border.
TEST(MeshSide, BehindAnOpenSheetBodiesAreLeftAlone) {
  const Body sheet = mesh_body(1, hills(0));
  EXPECT_TRUE(collide_two(sphere(0, 0.05, Vec3(0, 0, -0.9)), sheet, {}).points.empty());
  EXPECT_TRUE(collide_two(sphere(0, 0.05, Vec3(1.2, 0, -0.1)), sheet, {}).points.empty());
}

}  // namespace unibody::samples::mesh_side_test
