#include "meshes/mesh_topology.hpp"

#include <algorithm>
#include <tuple>

#include "core/errors.hpp"
#include "meshes/sets.hpp"

namespace unibody {

namespace {

using Triangle = std::array<std::int32_t, 3>;

// A triangle's side, sorted so that the sides of an edge stand together.
struct Side {
  std::int32_t low, high, triangle, opposite;
  auto key() const { return std::tuple(low, high, triangle); }
};

[[noreturn]] void fail(const std::string& origin, const std::string& found, const std::string& expected) {
  throw InputError(origin + ": found " + found + ", expected " + expected);
}

std::string named(const char* what, std::int64_t number) { return std::string(what) + " " + std::to_string(number); }
std::string pair_of(const char* what, std::int64_t a, std::int64_t b) {
  return std::string(what) + " " + std::to_string(a) + " and " + std::to_string(b);
}

void check_nodes(const TriangleMesh& mesh, const std::string& origin) {
  const auto count = static_cast<std::int64_t>(mesh.nodes.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Triangle& n = mesh.triangles[t];
    for (const std::int32_t node : n)
      if (node < 0 || node >= count)
        fail(origin, named("triangle", static_cast<std::int64_t>(t)) + named(" with node", node),
             "nodes in [0, " + std::to_string(count) + ")");
    if (n[0] == n[1] || n[1] == n[2] || n[2] == n[0])
      fail(origin, named("triangle", static_cast<std::int64_t>(t)) + named(" with node", n[0] == n[1] ? n[0] : n[2]) + " twice",
           "three different nodes");
  }
}

void check_repeated(const TriangleMesh& mesh, const std::string& origin) {
  std::vector<std::pair<Triangle, std::size_t>> sorted;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    sorted.emplace_back(mesh.triangles[t], t);
    std::sort(sorted[t].first.begin(), sorted[t].first.end());
  }
  std::sort(sorted.begin(), sorted.end());
  for (std::size_t t = 1; t < sorted.size(); ++t)
    if (sorted[t].first == sorted[t - 1].first)
      fail(origin,
           pair_of("triangles", static_cast<std::int64_t>(sorted[t - 1].second), static_cast<std::int64_t>(sorted[t].second)) +
               " with the same nodes",
           "each triangle once");
}

std::vector<Side> sorted_sides(const TriangleMesh& mesh) {
  std::vector<Side> sides;
  sides.reserve(3 * mesh.triangles.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (std::size_t k = 0; k < 3; ++k) {
      const auto [low, high] = std::minmax({mesh.triangles[t][k], mesh.triangles[t][(k + 1) % 3]});
      sides.push_back({low, high, static_cast<std::int32_t>(t), mesh.triangles[t][(k + 2) % 3]});
    }
  std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) { return a.key() < b.key(); });
  return sides;
}

std::int32_t count_components(const TriangleMesh& mesh) {
  Sets sets(mesh.nodes.size());
  for (const Triangle& n : mesh.triangles) sets.join(n[0], n[1]), sets.join(n[1], n[2]);
  std::int32_t count = 0;
  std::vector<bool> seen(mesh.nodes.size(), false);
  for (const Triangle& n : mesh.triangles) {
    const auto root = static_cast<std::size_t>(sets.root(n[0]));
    count += !seen[root];
    seen[root] = true;
  }
  return count;
}

// Whether the triangle goes along the edge from its lower to its higher node.
bool goes_up(const Triangle& n, const MeshEdge& edge) {
  for (std::size_t k = 0; k < 3; ++k)
    if (n[k] == edge.nodes[0]) return n[(k + 1) % 3] == edge.nodes[1];
  return false;
}

// Neighbours agree where they go along their edge in opposite ways.
bool neighbours_agree(const TriangleMesh& mesh, const MeshEdge& edge) {
  return goes_up(mesh.triangles[static_cast<std::size_t>(edge.triangles[0])], edge) !=
         goes_up(mesh.triangles[static_cast<std::size_t>(edge.triangles[1])], edge);
}

}  // namespace

MeshTopology mesh_topology(const TriangleMesh& mesh, const std::string& origin) {
  check_nodes(mesh, origin);
  check_repeated(mesh, origin);
  MeshTopology topology;
  for (const Side& side : sorted_sides(mesh)) {
    const std::array<std::int32_t, 2> nodes{side.low, side.high};
    if (topology.edges.empty() || topology.edges.back().nodes != nodes) {
      topology.edges.push_back({nodes, {side.triangle, -1}, {side.opposite, -1}});
      continue;
    }
    MeshEdge& edge = topology.edges.back();
    if (!edge.is_boundary())
      fail(origin,
           "triangles " + std::to_string(edge.triangles[0]) + ", " + pair_of("", edge.triangles[1], side.triangle).substr(1) +
               " at the edge of " + pair_of("nodes", nodes[0], nodes[1]),
           "at most two triangles at an edge");
    edge.triangles[1] = side.triangle, edge.opposite[1] = side.opposite;
  }
  for (std::size_t e = 0; e < topology.edges.size(); ++e)
    if (topology.edges[e].is_boundary()) topology.boundary.push_back(static_cast<std::int32_t>(e));
  topology.components = count_components(mesh);
  return topology;
}

std::int64_t orient_triangles(TriangleMesh& mesh, const MeshTopology& topology, const std::string& origin) {
  const std::size_t count = mesh.triangles.size();
  std::vector<std::vector<const MeshEdge*>> inner(count);
  for (const MeshEdge& edge : topology.edges)
    if (!edge.is_boundary())
      for (const std::int32_t t : edge.triangles) inner[static_cast<std::size_t>(t)].push_back(&edge);
  std::int64_t turned = 0;
  std::vector<bool> done(count, false);
  std::vector<std::size_t> front;
  for (std::size_t seed = 0; seed < count; ++seed) {
    if (!done[seed]) front.push_back(seed), done[seed] = true;
    while (!front.empty()) {
      const std::size_t t = front.back();
      front.pop_back();
      for (const MeshEdge* edge : inner[t]) {
        const auto other = static_cast<std::size_t>(edge->triangles[static_cast<std::size_t>(edge->triangles[0]) == t ? 1 : 0]);
        if (done[other]) continue;
        done[other] = true;
        front.push_back(other);
        if (!neighbours_agree(mesh, *edge)) std::swap(mesh.triangles[other][1], mesh.triangles[other][2]), ++turned;
      }
    }
  }
  for (const MeshEdge& edge : topology.edges)
    if (!edge.is_boundary() && !neighbours_agree(mesh, edge))
      fail(origin, "a surface of one side, closed at " + pair_of("triangles", edge.triangles[0], edge.triangles[1]),
           "a surface with an inside and an outside");
  return turned;
}

void check_mesh(const TriangleMesh& mesh, const std::string& origin) {
  const MeshTopology topology = mesh_topology(mesh, origin);
  std::vector<bool> used(mesh.nodes.size(), false);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Triangle& n = mesh.triangles[t];
    for (const std::int32_t node : n) used[static_cast<std::size_t>(node)] = true;
    const auto node = [&](std::size_t k) -> const Vec3& { return mesh.nodes[static_cast<std::size_t>(n[k])]; };
    const double longest =
        std::max({(node(1) - node(0)).squaredNorm(), (node(2) - node(1)).squaredNorm(), (node(0) - node(2)).squaredNorm()});
    if (!((node(1) - node(0)).cross(node(2) - node(0)).norm() >= 1e-8 * longest) || longest == 0)
      fail(origin, named("triangle", static_cast<std::int64_t>(t)) + " without area", "a height of 1e-8 of the longest edge");
  }
  for (const MeshEdge& edge : topology.edges)
    if (!edge.is_boundary() && !neighbours_agree(mesh, edge))
      fail(origin, pair_of("triangles", edge.triangles[0], edge.triangles[1]) + " with opposite sides out",
           "neighbours that list their nodes in the same sense");
  const auto lone = std::find(used.begin(), used.end(), false);
  if (lone != used.end()) fail(origin, named("node", lone - used.begin()) + " in no triangle", "each node in a triangle");
}

}  // namespace unibody
