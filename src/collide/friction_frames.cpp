#include "collide/friction_frames.hpp"

#include <cmath>

#include "world/surface_velocity.hpp"

namespace unibody {

namespace {

// A symmetric matrix in the plane across the normal: of the logarithms of factors.
struct Logarithms {
  double ss = 0, tt = 0, st = 0;

  void add(const World& world, Slot slot, const Vec3& s, const Vec3& t) {
    const auto i = static_cast<std::size_t>(slot);
    const FrictionAxis* of_body = find_axis(world.friction_axes, world.id[i]);
    if (of_body == nullptr) return;
    const Vec3 axis = scene_axes(world, i) * of_body->axis;
    const double log_across = std::log(of_body->across), along_s = axis.dot(s), along_t = axis.dot(t);
    ss += log_across * (1 - along_s * along_s), tt += log_across * (1 - along_t * along_t), st -= log_across * along_s * along_t;
  }
};

}  // namespace

FactoredFrame friction_frame(const World& world, Slot slot_a, Slot slot_b, const Vec3& normal) {
  const Vec3 s = first_tangent_of(normal), t = normal.cross(s);
  Logarithms sum;
  sum.add(world, slot_a, s, t);
  if (slot_b >= 0) sum.add(world, slot_b, s, t);
  const double mean = 0.5 * (sum.ss + sum.tt), half = 0.5 * (sum.ss - sum.tt), radius = std::hypot(half, sum.st);
  constexpr double same = 1e-12;  // of the logarithms: what rounding leaves has no direction
  if (radius <= same) return {{s, 1}, std::exp(mean)};
  const double angle = 0.5 * std::atan2(sum.st, half);  // of the larger coefficient, from s
  return {{std::cos(angle) * s + std::sin(angle) * t, std::exp(-2 * radius)}, std::exp(mean + radius)};
}

void add_friction_frames(const World& world, Contacts& contacts) {
  contacts.frames.clear(), contacts.surface_frames.clear();
  for (Manifold& m : contacts.manifolds) {
    const FactoredFrame found = friction_frame(world, m.slot_a, m.slot_b, m.normal);
    contacts.frames.push_back(found.frame), m.friction *= found.factor;
  }
  for (SurfaceContact& c : contacts.surface) {
    const FactoredFrame found = friction_frame(world, c.slots[0], -1, c.normal);
    contacts.surface_frames.push_back(found.frame), c.friction *= found.factor;
  }
}

}  // namespace unibody
