// What lies on a turning body is carried along a circle, while rows are linear in the step: a row that asks for no sliding along
// the tangent would let it creep outwards, by exp(h w^2 t / 2). So the velocity at which a contact's tangents aim has a part
// more: by how much the mean velocity over the step of what is carried differs from its velocity along the tangent. The normal
// row of what is carried at a wall has that part too: a wall that turns comes inwards by h^2 w^2 r / 2 in a step against what
// goes along the tangent, which would sink into it where that is more than what is recovered of a penetration.
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

// Returns the speed (m/s) at which a body has to part from its carrier along the contact's normal n, so that the carrier's
// surface, which turns, has not caught it at the end of the step. The arguments are those of drift_along_circle(); spin is the
// body's, rad/s.
//
// - A surface that moves along its normal, as a blade's does, comes to another place and turns its normal. The speed then is
//   n . (h w x s + h w x (w x from) / 2), where s is the velocity at which the body slides on it. Only driven carriers,
//   whose motion is given, are taken for blades: of two free bodies nobody knows which of them has the face of the contact.
// - A surface that moves along itself, as a drum's wall or a roller does, stays where it was. Only a body that goes round with it
//   would leave its circle along the tangent; the more a body slides, the less it does.
// - A body that turns against its carrier may touch it with a face of its own. The faster it turns, the less is asked of
//   it. Round bodies roll, and their turn does not matter.
//
// Where the surface recedes, the speed is 0: the body meets it a step later.
inline double closing_along_normal(const Vec3& turn, const Vec3& from, const Vec3& velocity, const Vec3& spin, bool is_round,
                                   bool driven, const Vec3& n, double step) {
  const Vec3 along = turn.cross(from);
  const double speed = along.norm();
  if (!(speed > 0)) return 0;
  const Vec3 sliding = velocity - along, round = drift_along_circle(turn, from, along, step);
  const double known = is_round ? 1 : std::max(0.0, 1 - (spin - turn).norm() / turn.norm());
  const double sticks = std::max(0.0, 1 - sliding.norm() / speed), across = n.dot(along) / speed;
  const double blade = driven ? across * across : 0;
  return std::max(0.0, known * n.dot((blade + (1 - blade) * sticks) * round + blade * step * turn.cross(sliding)));
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
