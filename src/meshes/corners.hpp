// Triangles by their corners, of which equal ones become one node.
#pragma once

#include <map>
#include <span>

#include "meshes/triangle_mesh.hpp"

namespace unibody {

// Whether a polygon, seen along its mean normal, turns left at every corner, and so does every triangle of the fan from its first
// corner (which a star's don't). Straight corners pass.
bool is_convex(std::span<const Vec3> polygon);

class CornerMesh {
 public:
  TriangleMesh mesh;

  // soup: triangles may have a corner twice
  explicit CornerMesh(bool soup) : soup_(soup) {}

  // False, and nothing is added, where two corners are the same, unless that may be.
  bool add(const std::array<Vec3, 3>& corners) {
    std::array<std::int32_t, 3> t;
    for (std::size_t k = 0; k < 3; ++k) t[k] = node(corners[k]);
    if (!soup_ && (t[0] == t[1] || t[1] == t[2] || t[2] == t[0])) return false;
    mesh.triangles.push_back(t);
    return true;
  }

 private:
  std::int32_t node(const Vec3& x) {
    const std::array<double, 3> key{x.x() + 0.0, x.y() + 0.0, x.z() + 0.0};  // -0 becomes 0
    const auto [at, is_new] = numbers_.try_emplace(key, static_cast<std::int32_t>(mesh.nodes.size()));
    if (is_new) mesh.nodes.emplace_back(key[0], key[1], key[2]);
    return at->second;
  }
  std::map<std::array<double, 3>, std::int32_t> numbers_;
  bool soup_;
};

}  // namespace unibody
