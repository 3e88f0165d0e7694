// SurfaceCollider: boxes against faces.

#include <algorithm>
#include <cmath>

#include "collide/convex_distance.hpp"
#include "collide/surface_contacts.hpp"
#include "collide/triangle_distance.hpp"

namespace unibody {

// The share of the step at which a box, without turning, first touches a face; 2: not within it.
double SurfaceCollider::first_touch(const Proxy& box, const SurfaceFace& face, double radius) const {
  const ContinuousSettings settings = continuous(radius);
  const Vec3 motion = settings_.step * box.velocity;
  const MovingPoint nodes[3] = {path(face.nodes[0]), path(face.nodes[1]), path(face.nodes[2])};
  std::array<MovingPoint, 8> corners;
  for (int k = 0; k < 8; ++k) {
    const Vec3 sign(k & 1 ? 1 : -1, k & 2 ? 1 : -1, k & 4 ? 1 : -1);
    const Vec3 corner = box.position + box.rotation * sign.cwiseProduct(box.half);
    corners[static_cast<std::size_t>(k)] = {corner, corner + motion};
  }
  double first = 2;
  const auto note = [&](const ContinuousHit& hit) {
    if (hit.hit) first = std::min(first, hit.time);
  };
  for (const MovingPoint& corner : corners) note(point_meets_triangle(corner, nodes[0], nodes[1], nodes[2], settings));
  for (std::size_t k = 0; k < 8; ++k)
    for (const std::size_t bit : {1u, 2u, 4u}) {
      if ((k & bit) != 0) continue;
      for (std::size_t i = 0; i < (face.is_segment() ? 1 : 3); ++i)
        note(edge_meets_edge(corners[k], corners[k | bit], nodes[i], nodes[(i + 1) % 3], settings));
    }
  return first;
}

// The third nodes of the neighbours that lean away by less than 45 degrees; returns how many.
std::size_t SurfaceCollider::flat_neighbours(const SurfaceFace& face, double time, std::array<Vec3, 3>& out) const {
  if (face.is_segment()) return 0;
  const TriangleNodes x = places(face, time);
  const Vec3 normal = (x[1] - x[0]).cross(x[2] - x[0]).normalized();
  std::size_t count = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    if (face.across[i] < 0) continue;
    const Vec3 node = place(face.across[i], time);
    const Vec3 &from = x[i], &to = x[(i + 1) % 3];
    if (normal.dot((from - to).cross(node - to).normalized()) > std::sqrt(0.5)) out[count++] = node;
  }
  return count;
}

SurfaceCollider::Approach SurfaceCollider::approach(const Proxy& solid, const SurfaceFace& face, FirstTouch first) const {
  Approach result;
  Pair& pair = result.pair;
  pair.slots = {solid.slot, face.nodes[0], face.nodes[1], face.nodes[2]};
  pair.radii = radius(face.nodes[0]), pair.spin = solid.turn_reach();
  if (travel(solid, face) > solid.half_size) {
    const double touch = (this->*first)(solid, face, pair.radii);
    pair.watched = touch > 1;
    result.time = pair.watched ? 0 : touch;
  }
  double fastest = solid.speed;
  for (const Slot s : face.nodes) fastest = std::max({fastest, velocity(s).norm(), (velocity(s) - solid.velocity).norm()});
  const double fall = settings_.gravity.norm() * settings_.step * settings_.step;
  const double travelled = pair.watched || result.time > 0 ? 0 : settings_.step * fastest;
  result.reach = pair.radii + (settings_.margin + travelled + pair.spin + fall);
  result.centre = centre_of(solid, result.time);
  return result;
}

void SurfaceCollider::add_touch(Approach& approach, const Vec3& weights, const Vec3& arm, const Vec3& normal, double apart,
                                std::uint32_t feature) {
  Pair& pair = approach.pair;
  pair.weights = {1, -weights[0], -weights[1], -weights[2]};
  const double gap = apart - pair.radii;
  if (approach.time == 0 && gap > margin(pair, normal)) return;
  const double closed = std::max(0.0, -approach.time * settings_.step * normal.dot(parting(pair)));
  const Vec3 passed = time_ > 0 ? Vec3(time_ * settings_.step * parting(pair)) : Vec3(Vec3::Zero());
  add(pair, arm + passed, normal, gap + closed, feature);
}

void SurfaceCollider::box_face(const Proxy& box, const SurfaceFace& face) {
  Approach near = approach(box, face, &SurfaceCollider::first_touch);
  stand_or_pass(box, face, near, [&](Approach& then) { return stand_by_box(then, box, face); });
}

bool SurfaceCollider::stand_by_box(Approach& near, const Proxy& box, const SurfaceFace& face) {
  TriangleContacts found;
  std::array<Vec3, 3> beyond;
  const std::size_t flat = flat_neighbours(face, near.time, beyond);
  box_triangle(near.centre, box.rotation, box.half, places(face, near.time), {near.reach, box.half_size}, found,
               std::span(beyond).first(flat));
  bool says = false;
  for (int i = 0; i < found.count; ++i) {
    const TriangleContact& c = found.points[static_cast<std::size_t>(i)];
    if (c.feature >= 8 && c.feature < 11) {  // nodes touch bodies as the particles that they are
      says |= time_ > 0 && is_nearest(face, c.weights, c.normal, lean_of_boxes);
      continue;
    }
    const Vec3 weights = without_twin(face, c.weights);
    if (face.is_segment() && ((c.feature >= 11 && (c.feature - 11) % 3 != 0) || is_one_node(weights))) continue;
    const bool own = owns(face, weights);
    if ((time_ == 0 && !own) || !is_nearest(face, weights, c.normal, lean_of_boxes)) continue;
    says = true;
    if (!own) continue;
    // the far side of a thin part of a solid is no wall for a corner that is through it
    const bool on_face = c.feature < 8 && (weights.array() > 0).all();
    if (on_face && surfaces_.is_closed(face.surface) && is_inwards(face, weights, c.normal)) continue;
    add_touch(near, weights, c.position - 0.5 * c.gap * c.normal - near.centre, c.normal, c.gap, c.feature);
  }
  return says;
}

}  // namespace unibody
