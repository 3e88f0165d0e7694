#include "collide/restitution.hpp"

#include "core/room.hpp"

namespace unibody {

void set_bounces(const World& world, const CollideSettings& settings, Contacts& contacts) {
  make_room(contacts.bounce, contacts.points.size());
  contacts.bounce.assign(contacts.points.size(), 0);
  const double slowest = 2 * settings.step * settings.gravity.norm();
  for (const Manifold& m : contacts.manifolds) {
    const auto a = static_cast<std::size_t>(m.slot_a), b = static_cast<std::size_t>(m.slot_b);
    const auto material = [&](std::size_t s) { return static_cast<std::size_t>(world.properties[s].material); };
    const double e = settings.restitution[material(a) * settings.material_count + material(b)];
    if (!(e > 0)) continue;
    for (std::uint32_t p = m.first; p < m.first + m.count; ++p) {
      const ContactPoint& point = contacts.points[p];
      const auto at = [&](std::size_t s) -> Vec3 {
        return world.velocity[s] + world.angular_velocity_of(s).cross(point.position - world.position[s]);
      };
      const double parting = m.normal.dot(at(a) - at(b));
      if (parting < -slowest && point.gap + settings.step * parting <= 0) contacts.bounce[p] = -e * parting;
    }
  }
}

}  // namespace unibody
