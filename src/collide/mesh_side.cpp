#include "collide/mesh_side.hpp"

#include <array>
#include <cmath>

#include "collide/triangle_distance.hpp"

namespace unibody {

namespace {

struct Nearest {
  const MeshSurface::Triangle* triangle = nullptr;
  TrianglePoint at;
};

double squared_distance(const MeshSurface::Branch& branch, const Vec3& x) {
  return (x - x.cwiseMax(branch.low).cwiseMin(branch.high)).squaredNorm();
}

Nearest find_nearest(const MeshSurface& mesh, const Vec3& x, double limit) {
  Nearest nearest;
  double best = limit * limit;
  std::array<std::pair<std::size_t, double>, 64> waiting;  // one a level of the tree
  std::size_t count = 0;
  waiting[count++] = {0, squared_distance(mesh.tree[0], x)};
  while (count > 0) {
    const auto [k, bound] = waiting[--count];
    if (bound > best) continue;
    const MeshSurface::Branch& branch = mesh.tree[k];
    for (std::int32_t i = branch.first; i < branch.first + branch.count; ++i) {
      const auto& triangle = mesh.triangles[static_cast<std::size_t>(mesh.order[static_cast<std::size_t>(i)])];
      const auto node = [&](std::size_t n) -> const Vec3& { return mesh.nodes[static_cast<std::size_t>(triangle.nodes[n])]; };
      const TrianglePoint at = closest_on_triangle(x, node(0), node(1), node(2));
      const double squared = at.distance * at.distance;
      if (squared > best || (nearest.triangle && squared == best)) continue;
      best = squared, nearest = {&triangle, at};
    }
    if (branch.count > 0) continue;
    const std::pair left{2 * k + 1, squared_distance(mesh.tree[2 * k + 1], x)},
        right{2 * k + 2, squared_distance(mesh.tree[2 * k + 2], x)};
    const bool left_first = left.second <= right.second;
    waiting[count++] = left_first ? right : left;
    waiting[count++] = left_first ? left : right;
  }
  return nearest;
}

// The mean of the two triangles at edge k; 0 on a border.
Vec3 edge_normal(const MeshSurface& mesh, const MeshSurface::Triangle& t, std::size_t k) {
  if (t.across[k] < 0) return Vec3::Zero();
  const auto node = [&](std::int32_t n) -> const Vec3& { return mesh.nodes[static_cast<std::size_t>(n)]; };
  const Vec3 &from = node(t.nodes[k]), &to = node(t.nodes[(k + 1) % 3]);
  return (t.normal + (from - to).cross(node(t.across[k]) - to).normalized()).normalized();
}

Vec3 normal_at(const MeshSurface& mesh, const Nearest& nearest) {
  const MeshSurface::Triangle& t = *nearest.triangle;
  switch (nearest.at.feature()) {
    case 1:
    case 2:
    case 4:
      return mesh.node_normals[static_cast<std::size_t>(t.nodes[nearest.at.feature() / 2])];
    case 3:
      return edge_normal(mesh, t, 0);
    case 6:
      return edge_normal(mesh, t, 1);
    case 5:
      return edge_normal(mesh, t, 2);
    default:
      return t.normal;
  }
}

}  // namespace

bool find_place(const MeshSurface& mesh, const Vec3& x, double limit, MeshPlace& place) {
  const Nearest nearest = find_nearest(mesh, x, limit);
  if (!nearest.triangle) return false;
  place.point = nearest.at.point, place.normal = normal_at(mesh, nearest);
  place.depth = place.normal.dot(x - place.point) > 0 ? -nearest.at.distance : nearest.at.distance;
  return place.normal != Vec3::Zero();
}

}  // namespace unibody
