#include "collide/corners_ahead.hpp"

#include <cmath>

#include "world/shape_type.hpp"

namespace unibody {

namespace {

constexpr double least_turn = 0.05;                // rad in the step
constexpr std::uint32_t first_feature = 1u << 17;  // beyond those of convex_pairs.cpp
constexpr double apart = 1e-3;                     // of the smaller half size: points nearer to each other are one

bool has_more_corners(const Proxy& p) { return p.kind == ShapeKind::hull || p.kind == ShapeKind::cylinder; }

// m, world: the point of a convex solid that is furthest in a direction.
Vec3 furthest(const Proxy& p, const Vec3& direction) {
  return p.position + p.rotation * type_of(p.kind).convex->support(p.shape(), p.rotation.transpose() * direction);
}

// Whether a point, with `gap` (m) to go along `way` (unit), comes to a flat side of the other solid.
bool is_over(const Proxy& other, const Vec3& point, double gap, const Vec3& way) {
  if (other.kind == ShapeKind::plane) return true;
  const Vec3 inside = point + (gap + apart * other.half_size) * way;
  return type_of(other.kind).convex->contains(other.shape(), other.rotation.transpose() * (inside - other.position));
}

void add_corners_of(const Proxy& body, const Proxy& other, const Vec3& origin, const Vec3& way, double step, double margin,
                    std::uint32_t feature, PairManifold& m) {
  Vec3 turn = step * (body.spin - other.spin);
  if (body.kind == ShapeKind::cylinder) {  // about its axis it is the same all around
    const Vec3 axis = body.rotation.col(2);
    turn -= axis.dot(turn) * axis;
  }
  if (!body.dynamic || !has_more_corners(body) || !(turn.norm() > least_turn)) return;
  if (other.kind != ShapeKind::plane && !type_of(other.kind).convex) return;
  const Vec3 surface = other.kind == ShapeKind::plane ? other.position : furthest(other, -way);
  const Vec3 tilt = way.cross(turn), aside = 0.5 * turn.norm() * way.cross(tilt).normalized();
  for (const Vec3& lean : {Vec3(0.5 * tilt), tilt, Vec3(0.5 * tilt + aside), Vec3(0.5 * tilt - aside)}) {
    const Vec3 corner = furthest(body, way + lean);
    const double gap = way.dot(surface - corner);
    if (!(gap <= margin) || !is_over(other, corner, gap, way)) continue;
    const Vec3 place = corner + 0.5 * gap * way - origin;
    bool is_new = true;
    for (int k = 0; k < m.count; ++k)
      is_new = is_new && (m.points[k].position - place).norm() > apart * std::min(body.half_size, other.half_size);
    if (is_new) m.add(place, gap, feature++);
  }
}

}  // namespace

void add_corners_ahead(const Proxy& first, const Proxy& second, double step, double margin, PairManifold& m) {
  if (m.count == 0) return;
  add_corners_of(first, second, first.position, -m.normal, step, margin, first_feature, m);
  add_corners_of(second, first, first.position, m.normal, step, margin, first_feature + 4, m);
}

}  // namespace unibody
