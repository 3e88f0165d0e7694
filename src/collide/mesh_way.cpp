#include "collide/mesh_way.hpp"

#include <algorithm>
#include <cmath>

#include "collide/triangle_distance.hpp"

namespace unibody {

namespace {

constexpr int most_triangles = 24;
constexpr double come_to = 1e-6;  // of a body's size
constexpr double deepest = -0.5;  // of half of it: the gap of a body that a triangle still holds in front of it

// A triangle's nodes from where the body's centre is.
std::array<Vec3, 3> seen_from(const Vec3& place, const MeshSurface& mesh, const MeshSurface::Triangle& t) {
  std::array<Vec3, 3> nodes;
  for (std::size_t k = 0; k < 3; ++k) nodes[k] = mesh.nodes[static_cast<std::size_t>(t.nodes[k])] - place;
  return nodes;
}

// m, of a body over a triangle's plane.
double gap_over(const MeshEncounter& e, const Vec3& on_plane, const Vec3& normal) {
  const double lowest = is_round(e.body.shape) ? -e.half_size : normal.dot(e.body.support(-normal)) - e.body.rounding;
  return lowest - normal.dot(on_plane);
}

// Whether a body that has come to a triangle's plane is over the triangle, too.
bool is_over(const MeshEncounter& e, const std::array<Vec3, 3>& nodes) {
  if (is_round(e.body.shape))
    return closest_on_triangle(Vec3::Zero(), nodes[0], nodes[1], nodes[2]).distance <= (1 + come_to) * e.half_size;
  ConvexDistance distance;
  return distance_of_cores(e.body, convex_triangle(nodes, e.body.size), come_to * e.body.size, distance) != Cores::far;
}

// What is a little behind a triangle would come to the planes of the next ones before it is over them.
Vec3 in_front(const MeshEncounter& e, const MeshSurface& mesh, std::span<const MeshSurface::Triangle* const> near) {
  Vec3 place = e.place;
  for (const MeshSurface::Triangle* t : near) {
    const std::array<Vec3, 3> nodes = seen_from(place, mesh, *t);
    const double gap = gap_over(e, nodes[0], t->normal);
    if (gap < 0 && gap > deepest * e.half_size && is_over(e, nodes)) place -= gap * t->normal;
  }
  return place;
}

}  // namespace

Vec3 velocity_seen(const Vec3& place, const Vec3& velocity, const Vec3& turn, double step) {
  const double rate = turn.norm();
  if (!(rate > 0 && step > 0)) return velocity;
  const Mat3 back = Eigen::AngleAxisd(-step * rate, turn / rate).toRotationMatrix();
  return (back * (place + step * velocity) - place) / step;
}

std::vector<const MeshSurface::Triangle*> triangles_on_way(const MeshEncounter& e, const MeshSurface& mesh,
                                                           std::span<const MeshSurface::Triangle* const> near) {
  std::vector<const MeshSurface::Triangle*> found;
  Vec3 place = in_front(e, mesh, near), velocity = e.velocity;
  double left = e.step;
  while (found.size() < most_triangles) {
    const MeshSurface::Triangle* next = nullptr;
    double time = left;
    for (const MeshSurface::Triangle* t : near) {
      const double closing = -t->normal.dot(velocity);
      if (!(closing > 0)) continue;
      const double gap = gap_over(e, mesh.nodes[static_cast<std::size_t>(t->nodes[0])] - place, t->normal);
      if (!(gap > deepest * e.half_size && gap < time * closing) || std::ranges::find(found, t) != found.end()) continue;
      const double at = std::max(0.0, gap) / closing;
      if (is_over(e, seen_from(place + at * velocity, mesh, *t))) time = at, next = t;
    }
    if (next == nullptr) break;
    found.push_back(next);
    place += time * velocity, left -= time;
    velocity -= next->normal.dot(velocity) * next->normal;
  }
  return found;
}

}  // namespace unibody
