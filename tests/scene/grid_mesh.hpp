// A mesh for the tests of meshes.
#pragma once

#include <array>

#include "meshes/triangle_mesh.hpp"

namespace unibody {

// A flat cloth: nodes[0] x nodes[1] nodes (2 at least) on a rectangle size[0] x size[1] (m) about the origin in the plane z = 0,
// node i + nodes[0] j at the i-th place along x and the j-th along y. Two triangles a cell, normals along +z; the diagonals of
// neighbouring cells cross, so that the cloth favours neither.
inline TriangleMesh grid_mesh(const std::array<double, 2>& size, const std::array<std::int32_t, 2>& nodes) {
  TriangleMesh mesh;
  const auto place = [&](std::size_t k, std::int32_t i) { return size[k] * (static_cast<double>(i) / (nodes[k] - 1) - 0.5); };
  for (std::int32_t j = 0; j < nodes[1]; ++j)
    for (std::int32_t i = 0; i < nodes[0]; ++i) mesh.nodes.emplace_back(place(0, i), place(1, j), 0.0);
  for (std::int32_t j = 0; j + 1 < nodes[1]; ++j)
    for (std::int32_t i = 0; i + 1 < nodes[0]; ++i) {
      const std::int32_t a = i + nodes[0] * j, b = a + 1, c = b + nodes[0], d = a + nodes[0];  // counterclockwise
      if ((i + j) % 2 == 0) {
        mesh.triangles.push_back({a, b, c}), mesh.triangles.push_back({a, c, d});
      } else {
        mesh.triangles.push_back({a, b, d}), mesh.triangles.push_back({b, c, d});
      }
    }
  return mesh;
}

}  // namespace unibody
