#include "collide/passage.hpp"

#include <array>
#include <vector>

namespace unibody {

namespace {

// Whether a point of a triangle's plane is in the triangle or on its border.
bool is_in(const MeshSurface& mesh, const MeshSurface::Triangle& t, const Vec3& point) {
  constexpr double rounding = 1e-9;
  const auto node = [&](std::size_t k) -> const Vec3& { return mesh.nodes[static_cast<std::size_t>(t.nodes[k % 3])]; };
  const double area = (node(1) - node(0)).cross(node(2) - node(0)).norm();
  for (std::size_t k = 0; k < 3; ++k)
    if (t.normal.dot((node(k + 1) - node(k)).cross(point - node(k))) < -rounding * area) return false;
  return true;
}

}  // namespace

Passage passage_through(const MeshSurface& mesh, const Vec3& from, const Vec3& to) {
  std::vector<std::int32_t> near;
  mesh.find(from.cwiseMin(to), from.cwiseMax(to), near);
  Passage first;
  for (const std::int32_t k : near) {
    const MeshSurface::Triangle& t = mesh.triangles[static_cast<std::size_t>(k)];
    const Vec3& node = mesh.nodes[static_cast<std::size_t>(t.nodes[0])];
    const double before = t.normal.dot(from - node), after = t.normal.dot(to - node);
    if (!((before > 0 && after <= 0) || (mesh.two_sided && before < 0 && after >= 0))) continue;
    const double share = before / (before - after), side = before > 0 ? 1 : -1;
    if (share < first.share && is_in(mesh, t, from + share * (to - from)))
      first = {share, side * t.normal, side * before, side * after};
  }
  return first;
}

// The distance from a convex solid is a convex function along a line: going on by what is left of it over the speed at which it
// shrinks never oversteps.
Passage passage_into(const ConvexBody& solid, const Vec3& from, const Vec3& to) {
  constexpr int most = 64;
  const Vec3 way = to - from;
  const double close = 1e-6 * solid.size, length = way.norm();
  ConvexDistance distance;
  const auto is_outside = [&](double share) {
    const Vec3 place = from + share * way;
    const std::array<Vec3, 3> point{place, place, place};
    ConvexDistance now;
    const Cores cores = distance_of_cores(convex_triangle(point, solid.size), solid, 2 * length, now);
    if (cores != Cores::apart || !(now.gap > (share > 0 ? close : 0))) return false;
    distance = now;
    return true;
  };
  if (!is_outside(0)) return {};
  double share = 0;
  for (int k = 0; k < most; ++k) {
    const double closing = -distance.normal.dot(way);
    if (!(closing > 0)) return {};
    share += distance.gap / closing;
    if (!(share <= 1)) return {};
    if (!is_outside(share)) break;
  }
  return {share, distance.normal, distance.normal.dot(from - distance.on_b), distance.normal.dot(to - distance.on_b)};
}

}  // namespace unibody
