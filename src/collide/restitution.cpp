#include "collide/restitution.hpp"

#include <algorithm>

#include "core/capacity.hpp"

namespace unibody {

namespace {

class Bounces {
 public:
  // starts: empty: the bodies' velocities are the world's.
  Bounces(const World& world, const CollideSettings& settings, std::span<const BounceStart> starts = {})
      : world_(world), settings_(settings), starts_(starts), slowest_(2 * settings.step * settings.gravity.norm()) {}

  double restitution(Slot a, Slot b) const { return settings_.restitution_of(material(a), material(b)); }
  // m/s: the speed at which two sides must part that part at `parting` now, `gap` m from each other; 0: they need not.
  double speed(double restitution, double gap, double parting) const {
    return parting < -slowest_ && gap + settings_.step * parting <= 0 ? -restitution * parting : 0;
  }

  void set(const Manifold& m, Contacts& contacts) const {
    const double e = restitution(m.slot_a, m.slot_b);
    if (!(e > 0)) return;
    for (std::uint32_t p = m.first; p < m.first + m.count; ++p) {
      const ContactPoint& point = contacts.points[p];
      const auto at = [&](Slot slot) -> Vec3 { return velocity(slot) + spin(slot).cross(arm_of(world_, m, point, slot)); };
      contacts.bounce[p] = speed(e, point.gap, m.normal.dot(at(m.slot_a) - at(m.slot_b)));
    }
  }

  void set(SurfaceContact& c) const {
    const auto second = std::find_if(c.weights.begin(), c.weights.end(), [](double w) { return w < 0; });
    const double e = restitution(c.slots[0], c.slots[static_cast<std::size_t>(second - c.weights.begin())]);
    if (!(e > 0)) return;
    Vec3 apart = spin(c.slots[0]).cross(c.arm);
    for (std::size_t k = 0; k < c.slots.size(); ++k)
      if (c.slots[k] >= 0) apart += c.weights[k] * velocity(c.slots[k]);
    c.bounce = speed(e, c.gap, c.normal.dot(apart));
  }

  bool is_changed(Slot s) const {
    const auto i = static_cast<std::size_t>(s);
    return starts_[i].velocity != world_.velocity[i] || starts_[i].spin != world_.angular_velocity_of(i);
  }

 private:
  Vec3 velocity(Slot s) const {
    const auto i = static_cast<std::size_t>(s);
    return starts_.empty() ? world_.velocity[i] : starts_[i].velocity;
  }
  Vec3 spin(Slot s) const {
    const auto i = static_cast<std::size_t>(s);
    return starts_.empty() ? world_.angular_velocity_of(i) : starts_[i].spin;
  }
  std::int32_t material(Slot s) const { return world_.properties[static_cast<std::size_t>(s)].material; }

  const World& world_;
  const CollideSettings& settings_;
  std::span<const BounceStart> starts_;
  double slowest_;
};

}  // namespace

void set_bounces(const World& world, const CollideSettings& settings, Contacts& contacts) {
  const Bounces bounces(world, settings);
  make_room(contacts.bounce, contacts.points.size());
  contacts.bounce.assign(contacts.points.size(), 0);
  for (const Manifold& m : contacts.manifolds) bounces.set(m, contacts);
  for (SurfaceContact& c : contacts.surface) bounces.set(c);
}

void renew_bounces(const World& world, const CollideSettings& settings, std::span<const BounceStart> starts,
                   std::span<const std::uint8_t> settled, Contacts& contacts) {
  const Bounces bounces(world, settings, starts);
  for (std::size_t k = 0; k < contacts.manifolds.size(); ++k) {
    const Manifold& m = contacts.manifolds[k];
    if (!settled[k] && (bounces.is_changed(m.slot_a) || bounces.is_changed(m.slot_b))) bounces.set(m, contacts);
  }
  const auto is_changed = [&](Slot s) { return s >= 0 && bounces.is_changed(s); };
  for (SurfaceContact& c : contacts.surface)
    if (std::ranges::any_of(c.slots, is_changed)) bounces.set(c);
}

}  // namespace unibody
