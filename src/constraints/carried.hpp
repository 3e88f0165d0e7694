// What lies on a turning body is carried along a circle, while rows are linear in the step: a row that asks for no sliding along
// the tangent would let it creep outwards, by exp(h w^2 t / 2). So the velocity at which a contact's tangents aim has a part
// more: by how much the mean velocity over the step of what is carried differs from its velocity along the tangent.
#pragma once

#include <algorithm>
#include <cmath>

#include "world/surface_velocity.hpp"
#include "world/world.hpp"

namespace unibody {

inline constexpr double least_turn = 1e-4, most_turn = 1;  // rad a step: below nothing shows, beyond no path is known

// m/s, of a body relative to its carrier. turn: the carrier's angular velocity (rad/s); from: from the carrier's centre to the
// body's (m); velocity: of the body relative to the carrier's centre (m/s). A body that sticks is taken along the circle's chord;
// one that slides meets the surface where it is half a step later.
inline Vec3 drift_along_circle(const Vec3& turn, const Vec3& from, const Vec3& velocity, double step) {
  const double rate = turn.norm(), angle = step * rate;
  if (!(angle >= least_turn && angle < most_turn)) return Vec3::Zero();
  const Mat3 rotation = Eigen::AngleAxisd(angle, turn / rate).toRotationMatrix();
  const Vec3 ahead = (rotation * from - from) / step, behind = (from - rotation.transpose() * from) / step;
  const Vec3 sliding = rotation * (velocity - behind);
  const double part = std::min(1.0, 2 * (most_turn - angle) / most_turn);
  return part * (ahead - turn.cross(from) + 0.5 * step * turn.cross(sliding));
}

// rad/s: of two bodies in contact the turn that they have in common. A kinematic body carries; of two that are free the one that
// turns less, as a ball turns fast on a disc that carries it; two round ones roll on each other.
struct CommonTurn {
  Vec3 turn = Vec3::Zero();
  bool a_carries = false;
};
inline CommonTurn common_turn(const World& world, Slot slot_a, Slot slot_b) {
  const auto a = static_cast<std::size_t>(slot_a), b = static_cast<std::size_t>(slot_b);
  const bool static_a = world.is_static(slot_a), static_b = world.is_static(slot_b);
  const auto turn_of = [&](std::size_t slot) { return world.angular_velocity_of(slot); };
  if (static_a || static_b) return {turn_of(static_a ? a : b), static_a};
  const Shape &shape_a = world.properties[a].shape, &shape_b = world.properties[b].shape;
  if (is_round(shape_a) && is_round(shape_b)) return {};
  if (shape_a.kind == ShapeKind::particle || shape_b.kind == ShapeKind::particle) {
    const bool a_carries = shape_b.kind == ShapeKind::particle;
    return {turn_of(a_carries ? a : b), a_carries};
  }
  const Vec3 of_a = turn_of(a), of_b = turn_of(b);
  if (!(of_a.dot(of_b) > 0)) return {};
  const bool a_carries = of_a.squaredNorm() < of_b.squaredNorm();
  return {a_carries ? of_a : of_b, a_carries};
}

// How a body that sticks moves against the one whose surface moves, from contact points with the normal n, whose middle is at the
// end of `arm` (m) from the carrier's centre: at the carrier's centre and about the normal, so that all points of the pair have
// what the surface has there. from: m, from the carrier's centre to the other body's. A surface that turns about the normal
// carries along a circle, as a turning body does.
inline OwnMotion drift_on_surface(const World& world, Slot carrier, Slot carried, const Vec3& arm, const Vec3& from,
                                  const Vec3& n, double step) {
  const auto c = static_cast<std::size_t>(carrier), o = static_cast<std::size_t>(carried);
  const OwnMotion own = own_motion(world, carrier);
  const Vec3 about_normal = n * n.dot(own.w), rolling = own.w - about_normal;
  Vec3 v = own.v + rolling.cross(arm);
  const Vec3 velocity = world.velocity[o] - world.velocity[c];
  v += drift_along_circle(about_normal, from, velocity - v, step);
  return {v - n * n.dot(v), about_normal};
}

}  // namespace unibody
