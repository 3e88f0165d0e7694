#include "collide/crossings.hpp"

#include <algorithm>
#include <cmath>

#include "collide/broadphase.hpp"
#include "collide/triangle_crossing.hpp"

namespace unibody {

namespace {

template <std::size_t Count>
Bounds bounds_of(std::span<const Vec3> positions, const std::array<Slot, Count>& nodes) {
  Bounds b{positions[nodes[0]], positions[nodes[0]]};
  for (const Slot node : nodes) {
    const Vec3& x = positions[node];
    if (!x.allFinite()) return {Vec3::Constant(NAN), Vec3::Constant(NAN)};  // min and max would lose it
    b.lower = b.lower.cwiseMin(x), b.upper = b.upper.cwiseMax(x);
  }
  // The broad phase chooses a level by size, which nodes at one point don't have.
  if (b.lower == b.upper) b.upper.array() += std::max(0x1p-40 * b.upper.cwiseAbs().maxCoeff(), 0x1p-40);
  return b;
}

bool share_node(const Edge& edge, const Face& face) {
  return std::any_of(face.begin(), face.end(), [&](Slot node) { return node == edge[0] || node == edge[1]; });
}

}  // namespace

std::vector<Crossing> find_crossings(std::span<const Vec3> positions, std::span<const Face> faces, std::span<const Edge> edges,
                                     std::span<const std::uint8_t> counted, std::pmr::memory_resource* memory) {
  const std::size_t count = edges.size() + faces.size();
  std::pmr::vector<Bounds> bounds(memory);
  std::pmr::vector<Role> roles(memory);
  bounds.reserve(count), roles.reserve(count);
  for (std::size_t e = 0; e < edges.size(); ++e) {
    bounds.push_back(bounds_of(positions, edges[e]));
    roles.push_back(counted.empty() || counted[e] != 0 ? Role::home : Role::absent);
  }
  for (const Face& face : faces) bounds.push_back(bounds_of(positions, face)), roles.push_back(Role::other);

  BroadPhase broad(memory);
  Pairs pairs(memory);
  broad.find(bounds, roles, pairs);

  std::vector<Crossing> crossings;
  const auto first_face = static_cast<std::int32_t>(edges.size());
  for (const IndexPair& pair : pairs) {
    if (pair.second < first_face) continue;  // two edges
    const Crossing candidate{pair.first, pair.second - first_face};
    const Edge& edge = edges[candidate.edge];
    const Face& face = faces[candidate.face];
    if (share_node(edge, face)) continue;
    if (edge_crosses_face(positions[edge[0]], positions[edge[1]], positions[face[0]], positions[face[1]], positions[face[2]]))
      crossings.push_back(candidate);
  }
  std::sort(crossings.begin(), crossings.end(),
            [](const Crossing& a, const Crossing& b) { return a.edge != b.edge ? a.edge < b.edge : a.face < b.face; });
  return crossings;
}

std::vector<Edge> unique_edges(std::span<const Face> faces) {
  std::vector<Edge> edges;
  edges.reserve(3 * faces.size());
  for (const Face& face : faces)
    for (std::size_t i = 0; i < 3; ++i) {
      const Slot a = face[i], b = face[(i + 1) % 3];
      if (a != b) edges.push_back({std::min(a, b), std::max(a, b)});
    }
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  return edges;
}

}  // namespace unibody
