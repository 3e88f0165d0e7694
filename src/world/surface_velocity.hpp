// How surfaces that move along themselves (world/surface_motion.hpp) move where something touches them.
#pragma once

#include "world/shapes.hpp"
#include "world/world.hpp"

namespace unibody {

// The axes in which the scene describes a body's shape: of hulls and compounds, whose orientation is that of their principal
// axes, others than these.
inline Quat scene_axes(const World& world, std::size_t slot) {
  const Shape& shape = world.properties[slot].shape;
  const Quat axes = world.orientation_of(slot);
  return shape.kind == ShapeKind::hull || shape.kind == ShapeKind::compound ? Quat(axes * frame_of(shape).conjugate()) : axes;
}

inline bool has_own_motion(const World& world, Slot slot) {
  return find_motion(world.surface_motions, world.id[static_cast<std::size_t>(slot)]) != nullptr;
}

inline OwnMotion own_motion(const World& world, Slot slot) {
  const auto i = static_cast<std::size_t>(slot);
  const SurfaceMotion* motion = find_motion(world.surface_motions, world.id[i]);
  if (motion == nullptr) return {};
  const Quat axes = scene_axes(world, i);
  return {axes * motion->velocity, axes * motion->angular_velocity};
}

// By how much what lies on one of the two is turned about the normal by the other's surface. rad/s
inline Vec3 own_turn(const World& world, Slot a, Slot b, const Vec3& n) {
  if (world.surface_motions.empty()) return Vec3::Zero();
  return n * n.dot(own_motion(world, a).w + own_motion(world, b).w);
}

// The velocity of a body's surface relative to the body, across the unit normal n, at the end of an arm (m) from the body's
// centre. m/s
inline Vec3 own_surface_velocity(const World& world, Slot slot, const Vec3& arm, const Vec3& n) {
  const OwnMotion own = own_motion(world, slot);
  const Vec3 v = own.v + own.w.cross(arm);
  return v - n * n.dot(v);
}

// The same of the surface of b relative to that of a: where the two stick, a moves so against b.
inline Vec3 surface_velocity_between(const World& world, Slot a, const Vec3& arm_a, Slot b, const Vec3& arm_b, const Vec3& n) {
  if (world.surface_motions.empty()) return Vec3::Zero();
  return own_surface_velocity(world, b, arm_b, n) - own_surface_velocity(world, a, arm_a, n);
}

}  // namespace unibody
