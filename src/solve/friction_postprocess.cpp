#include "solve/friction_postprocess.hpp"

#include <algorithm>
#include <array>
#include <vector>

#include "collide/collide.hpp"
#include "world/surface_velocity.hpp"

namespace unibody {

namespace {

// A point where two sides press on each other: the velocity at which they part is the sum of weight times velocity over the ends.
struct Touch {
  struct End {
    Slot slot = -1;
    double weight = 0;
    Vec3 arm = Vec3::Zero();  // m, from the centre
  };
  std::array<End, 4> of;
  std::size_t count;
  Vec3 normal;
  double limit;  // N s, mu lambda_n
  bool counted;

  std::span<const End> ends() const { return std::span(of).first(count); }
};

// All touches with friction, in key order.
std::vector<Touch> list_touches(const World& world, const Contacts& contacts, const System& system) {
  std::vector<Touch> touches;
  std::vector<double> normal(contacts.points.size());
  system.contacts().normal_impulses(normal);
  for (std::size_t i = 0; i < contacts.manifolds.size(); ++i) {
    const Manifold& m = contacts.manifolds[i];
    for (std::uint32_t p = m.first; p < m.first + m.count; ++p) {
      const double limit = m.friction * normal[p];
      if (limit <= 0) continue;
      const auto end = [&](Slot s, double weight) { return Touch::End{s, weight, arm_of(world, m, contacts.points[p], s)}; };
      touches.push_back({{end(m.slot_a, 1), end(m.slot_b, -1)}, 2, m.normal, limit, system.contacts().is_counted(i)});
    }
  }
  normal.resize(contacts.surface.size());
  system.batch<SurfaceBatch>().normal_impulses(normal);
  for (std::size_t i = 0; i < contacts.surface.size(); ++i) {
    const SurfaceContact& c = contacts.surface[i];
    const double limit = c.friction * normal[i];
    if (limit <= 0) continue;
    Touch touch{{}, 0, c.normal, limit, counts_here(world, c)};
    for (std::size_t k = 0; k < 4; ++k)
      if (c.slots[k] >= 0) touch.of[touch.count++] = {c.slots[k], c.weights[k], k == 0 ? c.arm : Vec3(Vec3::Zero())};
    touches.push_back(touch);
  }
  return touches;
}

// n W n, 1/kg, of a unit impulse along n on one end.
double mobility(const System& system, const Touch::End& end, const Vec3& n) {
  const auto i = static_cast<std::size_t>(end.slot);
  const SolverBody& body = system.bodies[i];
  const Vec3 a = end.arm.cross(n);
  if (system.isotropic[i]) return body.inverse_mass + body.inverse_inertia * a.squaredNorm();
  const InverseInertia& w = system.inertia[i];
  return body.inverse_mass + w.xx * a.x() * a.x() + w.yy * a.y() * a.y() + w.zz * a.z() * a.z() +
         2 * (w.yz * a.y() * a.z() + w.xz * a.x() * a.z() + w.xy * a.x() * a.y());
}

// Adds the friction of one touch to the wrenches of its ends. sharers: of each body's mass. Whether it slides on.
bool brake(const World& world, const Touch& touch, std::span<const std::int32_t> sharers, System& system) {
  Vec3 u = Vec3::Zero();
  for (const Touch::End& end : touch.ends()) {
    const SolverBody& body = system.bodies[static_cast<std::size_t>(end.slot)];
    u += end.weight * (Eigen::Map<const Vec3>(body.v) + Eigen::Map<const Vec3>(body.w).cross(end.arm));
    if (world.surface_motions.empty()) continue;
    u += end.weight * own_surface_velocity(world, end.slot, end.arm, touch.normal);
  }
  const Vec3 slip = u - touch.normal.dot(u) * touch.normal;
  const double speed = slip.norm();
  if (speed <= 0) return false;
  const Vec3 along = slip / speed;
  double w = 0;
  for (const Touch::End& end : touch.ends())
    w += end.weight * end.weight * sharers[static_cast<std::size_t>(end.slot)] * mobility(system, end, along);
  if (w <= 0) return false;
  const Vec3 impulse = -std::min(touch.limit, speed / w) * along;
  for (const Touch::End& end : touch.ends()) {
    Wrench& wrench = system.wrenches[static_cast<std::size_t>(end.slot)];
    const Vec3 force = end.weight * impulse, torque = end.arm.cross(force);
    wrench.force += Vec4d{force.x(), force.y(), force.z(), 0};
    wrench.torque += Vec4d{torque.x(), torque.y(), torque.z(), 0};
  }
  return touch.limit * w <= speed;
}

}  // namespace

std::int64_t postprocess_friction(const World& world, const Contacts& contacts, System& system, const Exchange& exchange) {
  const std::vector<Touch> touches = list_touches(world, contacts, system);
  std::vector<std::int32_t> sharers(system.bodies.size(), 0);
  for (const Touch& touch : touches)
    for (const Touch::End& end : touch.ends()) ++sharers[static_cast<std::size_t>(end.slot)];
  exchange.refresh(std::span(sharers));
  exchange.refresh(system.bodies);  // the guard of surfaces changes homes alone
  system.moving = system.bodies;
  system.wrenches.resize(system.bodies.size(), Wrench{});
  std::int64_t sliding = 0;
  for (const Touch& touch : touches) sliding += brake(world, touch, sharers, system) && touch.counted;
  system.apply_wrenches();
  return sliding;
}

}  // namespace unibody
