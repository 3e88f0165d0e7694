// Edges, boundaries and components against counting by brute force; every fault by its message.
#include "meshes/mesh_topology.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <map>
#include <random>
#include <set>

#include "core/errors.hpp"
#include "scene/grid_mesh.hpp"

namespace unibody::mesh_topology_test {
namespace {

using Triangle = std::array<std::int32_t, 3>;

// A strip of n x m cells closed around the first direction, and around the second if `torus`; twisted: a Moebius strip.
TriangleMesh ring(std::int32_t n, std::int32_t m, bool torus, bool twisted = false) {
  TriangleMesh mesh;
  const std::int32_t across = torus ? m : m + 1;
  for (std::int32_t i = 0; i < n; ++i)
    for (std::int32_t j = 0; j < across; ++j) {
      const double s = 2 * M_PI * i / n, t = torus ? 2 * M_PI * j / m : 0, w = torus ? 0 : 0.1 * (j - 0.5 * m);
      const double turn = twisted ? s / 2 : 0.5;
      const double r = 1 + 0.3 * std::cos(t) * torus + w * std::cos(turn);
      mesh.nodes.emplace_back(r * std::cos(s), r * std::sin(s), 0.3 * std::sin(t) * torus + w * std::sin(turn));
    }
  for (std::int32_t i = 0; i < n; ++i)
    for (std::int32_t j = 0; j < m; ++j) {
      const auto node = [&](std::int32_t p, std::int32_t q) {
        const bool around = p == n;
        const std::int32_t k = torus ? q % m : twisted && around ? m - q : q;
        return (around ? 0 : p) * across + k;
      };
      mesh.triangles.push_back({node(i, j), node(i + 1, j), node(i + 1, j + 1)});
      mesh.triangles.push_back({node(i, j), node(i + 1, j + 1), node(i, j + 1)});
    }
  return mesh;
}

TriangleMesh both(TriangleMesh a, const TriangleMesh& b) {
  const auto offset = static_cast<std::int32_t>(a.nodes.size());
  for (const Vec3& node : b.nodes) a.nodes.push_back(node + Vec3(5, 0, 0));
  for (const Triangle& t : b.triangles) a.triangles.push_back({t[0] + offset, t[1] + offset, t[2] + offset});
  return a;
}

std::int64_t euler(const TriangleMesh& mesh, const MeshTopology& topology) {
  return static_cast<std::int64_t>(mesh.nodes.size()) - static_cast<std::int64_t>(topology.edges.size()) +
         static_cast<std::int64_t>(mesh.triangles.size());
}

void expect_as_by_brute_force(const TriangleMesh& mesh) {
  std::map<std::array<std::int32_t, 2>, std::vector<std::pair<std::int32_t, std::int32_t>>> expected;  // triangle, opposite
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (const std::int32_t i : mesh.triangles[t])
      for (const std::int32_t j : mesh.triangles[t])
        for (const std::int32_t k : mesh.triangles[t])
          if (i < j && k != i && k != j) expected[{i, j}].emplace_back(static_cast<std::int32_t>(t), k);
  const MeshTopology topology = mesh_topology(mesh, "mesh");
  ASSERT_EQ(topology.edges.size(), expected.size());
  std::size_t e = 0, boundary = 0;
  for (const auto& [nodes, triangles] : expected) {
    const MeshEdge& edge = topology.edges[e];
    EXPECT_EQ(edge.nodes, nodes);
    EXPECT_EQ(edge.triangles[0], triangles[0].first);
    EXPECT_EQ(edge.opposite[0], triangles[0].second);
    EXPECT_EQ(edge.is_boundary(), triangles.size() == 1);
    EXPECT_EQ(edge.triangles[1], triangles.size() == 1 ? -1 : triangles[1].first);
    EXPECT_EQ(edge.opposite[1], triangles.size() == 1 ? -1 : triangles[1].second);
    if (triangles.size() == 1) {
      ASSERT_LT(boundary, topology.boundary.size());
      EXPECT_EQ(topology.boundary[boundary++], static_cast<std::int32_t>(e));
    }
    ++e;
  }
  EXPECT_EQ(boundary, topology.boundary.size());
}

TEST(MeshTopology, EdgesAsByBruteForce) {
  for (const auto& mesh : {grid_mesh({1, 2}, {2, 2}), grid_mesh({1, 2}, {7, 5}), ring(9, 4, true), ring(9, 4, false),
                           ring(8, 3, false, true), both(ring(5, 3, true), grid_mesh({1, 1}, {3, 4}))}) {
    expect_as_by_brute_force(mesh);
    TriangleMesh shuffled = mesh;  // triangles in any order, sides in any sense, holes
    std::mt19937 engine(1);
    std::shuffle(shuffled.triangles.begin(), shuffled.triangles.end(), engine);
    for (Triangle& t : shuffled.triangles) std::shuffle(t.begin(), t.end(), engine);
    expect_as_by_brute_force(shuffled);
    shuffled.triangles.resize(shuffled.triangles.size() * 3 / 4 + 1);
    expect_as_by_brute_force(shuffled);
  }
}

TEST(MeshTopology, EulerCharacteristicAndComponents) {
  const auto count = [](const TriangleMesh& mesh) {
    const MeshTopology t = mesh_topology(mesh, "mesh");
    return std::tuple(euler(mesh, t), t.boundary.size(), t.components);
  };
  EXPECT_EQ(count(grid_mesh({1, 1}, {7, 5})), std::tuple(1, 20u, 1));
  EXPECT_EQ(count(ring(12, 5, true)), std::tuple(0, 0u, 1));
  EXPECT_EQ(count(ring(12, 5, false)), std::tuple(0, 24u, 1));
  EXPECT_EQ(count(ring(12, 5, false, true)), std::tuple(0, 24u, 1));
  EXPECT_EQ(count(both(both(ring(12, 5, true), grid_mesh({1, 1}, {3, 3})), ring(5, 5, true))), std::tuple(1, 8u, 3));
  const TriangleMesh touching{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}}, {{0, 1, 2}, {0, 3, 4}}};
  EXPECT_EQ(mesh_topology(touching, "mesh").components, 1);
  check_mesh(touching, "mesh");
}

TEST(MeshTopology, GridIsARectangleOfRightSense) {
  const TriangleMesh mesh = grid_mesh({3, 2}, {7, 4});
  check_mesh(mesh, "grid");
  ASSERT_EQ(mesh.nodes.size(), 28u);
  ASSERT_EQ(mesh.triangles.size(), 36u);
  EXPECT_EQ(mesh.nodes[0], Vec3(-1.5, -1, 0));
  EXPECT_EQ(mesh.nodes[27], Vec3(1.5, 1, 0));
  EXPECT_EQ(mesh.nodes[6], Vec3(1.5, -1, 0));
  for (const Triangle& t : mesh.triangles) {
    const auto node = [&](std::size_t k) { return mesh.nodes[static_cast<std::size_t>(t[k])]; };
    EXPECT_LT(((node(1) - node(0)).cross(node(2) - node(0)) - Vec3(0, 0, 1.0 / 3)).norm(), 1e-14);
  }
  // alternating diagonals: an inner node has 4 or 8 neighbours, never 6
  std::map<std::int32_t, int> degree;
  for (const MeshEdge& edge : mesh_topology(mesh, "grid").edges) ++degree[edge.nodes[0]], ++degree[edge.nodes[1]];
  for (std::int32_t j = 1; j < 3; ++j)
    for (std::int32_t i = 1; i < 6; ++i) EXPECT_EQ(degree[i + 7 * j], (i + j) % 2 == 0 ? 8 : 4);
}

TEST(MeshTopology, TrianglesAreTurnedOverUntilNeighboursAgree) {
  std::mt19937 engine(3);
  for (const auto& mesh : {grid_mesh({1, 2}, {7, 5}), ring(9, 4, true), both(ring(5, 3, true), grid_mesh({1, 1}, {3, 4}))}) {
    TriangleMesh turned = mesh;
    std::int64_t count = 0;
    for (std::size_t t = 1; t < turned.triangles.size(); ++t)
      if (t != 30 && engine() % 2 == 0) std::swap(turned.triangles[t][1], turned.triangles[t][2]), ++count;
    const std::size_t second = 30;  // of the last mesh: first triangle of its second part, kept as it is
    EXPECT_EQ(turned.triangles[second], mesh.triangles[second]);
    EXPECT_THROW(check_mesh(turned, "mesh"), InputError);
    EXPECT_EQ(orient_triangles(turned, mesh_topology(turned, "mesh"), "mesh"), count);
    check_mesh(turned, "mesh");
    EXPECT_EQ(orient_triangles(turned, mesh_topology(turned, "mesh"), "mesh"), 0);
  }
}

std::string fault(const std::function<void()>& call) {
  try {
    call();
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(MeshTopology, FaultsAreNamed) {
  const std::vector<Vec3> nodes{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 0}};
  const auto check = [&](std::vector<Triangle> triangles) {
    TriangleMesh mesh{nodes, std::move(triangles)};
    return fault([&] { check_mesh(mesh, "flag"); });
  };
  EXPECT_EQ(check({{0, 1, 2}, {1, 4, 2}, {0, 3, 1}}), "");
  EXPECT_EQ(check({{0, 1, 2}, {0, 1, 5}}), "flag: found triangle 1 with node 5, expected nodes in [0, 5)");
  EXPECT_EQ(check({{0, 1, -1}}), "flag: found triangle 0 with node -1, expected nodes in [0, 5)");
  EXPECT_EQ(check({{0, 1, 2}, {3, 4, 3}}), "flag: found triangle 1 with node 3 twice, expected three different nodes");
  EXPECT_EQ(check({{0, 1, 2}, {1, 2, 2}}), "flag: found triangle 1 with node 2 twice, expected three different nodes");
  EXPECT_EQ(check({{0, 1, 2}, {1, 2, 4}, {2, 1, 0}}),
            "flag: found triangles 0 and 2 with the same nodes, expected each triangle once");
  EXPECT_EQ(check({{0, 1, 2}, {1, 0, 3}, {4, 0, 1}}),
            "flag: found triangles 0, 1 and 2 at the edge of nodes 0 and 1, expected at most two triangles at an edge");
  EXPECT_EQ(check({{0, 1, 2}, {1, 2, 4}}),
            "flag: found triangles 0 and 1 with opposite sides out, expected neighbours that list their nodes in the same sense");
  EXPECT_EQ(check({{0, 1, 2}, {1, 4, 2}}), "flag: found node 3 in no triangle, expected each node in a triangle");
  const auto height = [&](double h) {
    const TriangleMesh mesh{{{1e3, 0, 0}, {1e3 + 2, 0, 0}, {1e3 + 1, h, 0}}, {{0, 1, 2}}};
    return fault([&] { check_mesh(mesh, "flag"); });
  };
  EXPECT_EQ(height(2.1e-8), "");
  EXPECT_EQ(height(1.9e-8), "flag: found triangle 0 without area, expected a height of 1e-8 of the longest edge");
  EXPECT_EQ(height(0), "flag: found triangle 0 without area, expected a height of 1e-8 of the longest edge");
  TriangleMesh strip = ring(8, 2, false, true);
  const std::string message = fault([&] { orient_triangles(strip, mesh_topology(strip, "strip"), "strip"); });
  EXPECT_EQ(message.rfind("strip: found a surface of one side, closed at triangles ", 0), 0u) << message;
}

}  // namespace
}  // namespace unibody::mesh_topology_test
