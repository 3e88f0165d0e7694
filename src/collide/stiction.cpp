#include "collide/stiction.hpp"

#include <cmath>

#include "world/surface_velocity.hpp"

namespace unibody {

namespace {

// Over the coefficient in motion. u: m/s, of one side against the other, whatever its direction.
double factor(const CollideSettings& settings, int material_a, int material_b, const Vec3& u, const Vec3& normal) {
  const std::size_t pair = static_cast<std::size_t>(material_a) * settings.material_count + static_cast<std::size_t>(material_b);
  if (settings.stiction[pair] == 0) return 1;
  const double speed = (u - normal * normal.dot(u)).norm();
  return 1 + settings.stiction[pair] * std::exp(-speed / settings.stiction_speed[pair]);
}

Vec3 velocity_at(const World& world, Slot slot, const Vec3& arm) {
  const auto i = static_cast<std::size_t>(slot);
  return world.velocity[i] + world.angular_velocity_of(i).cross(arm);
}

}  // namespace

void add_stiction(const World& world, const CollideSettings& settings, Contacts& contacts) {
  const auto material = [&](Slot slot) { return world.properties[static_cast<std::size_t>(slot)].material; };
  for (Manifold& m : contacts.manifolds) {
    Vec3 middle = Vec3::Zero();
    for (std::uint32_t p = 0; p < m.count; ++p) middle += contacts.points[m.first + p].position / m.count;
    const ContactPoint at{middle, 0, 0};
    const Vec3 arm_a = arm_of(world, m, at, m.slot_a), arm_b = arm_of(world, m, at, m.slot_b);
    const Vec3 u = velocity_at(world, m.slot_a, arm_a) - velocity_at(world, m.slot_b, arm_b) -
                   surface_velocity_between(world, m.slot_a, arm_a, m.slot_b, arm_b, m.normal);
    m.friction *= factor(settings, material(m.slot_a), material(m.slot_b), u, m.normal);
  }
  for (SurfaceContact& c : contacts.surface) {
    Slot last = -1;
    Vec3 u = Vec3::Zero();
    for (std::size_t k = 0; k < 4; ++k) {
      if (c.slots[k] < 0) continue;
      last = c.slots[k];
      const Vec3 arm = k == 0 ? c.arm : Vec3(Vec3::Zero());
      u += c.weights[k] * velocity_at(world, last, arm);
      if (k == 0 && !world.surface_motions.empty()) u += c.weights[k] * own_surface_velocity(world, last, arm, c.normal);
    }
    c.friction *= factor(settings, material(c.slots[0]), material(last), u, c.normal);
  }
}

}  // namespace unibody
