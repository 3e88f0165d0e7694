#include "step/contact_forces.hpp"

#include <algorithm>
#include <utility>

#include "collide/collide.hpp"
#include "solve/batches.hpp"
#include "step/rank_state.hpp"

namespace unibody {

namespace {

bool moves_freely(const World& world, Slot slot) { return world.properties[static_cast<std::size_t>(slot)].is_dynamic(); }

Vec3 crossing_impulse_of(const RankState& state, const Manifold& m) {
  const auto number = static_cast<std::size_t>(&m - state.contacts.manifolds.data());
  const auto& crossings = state.rows.crossings;
  const auto found = std::ranges::lower_bound(crossings, number, {}, &CrossingImpulse::manifold);
  return found != crossings.end() && found->manifold == number ? found->on_a : Vec3(Vec3::Zero());
}

void add_bodies(const RankState& state, const ContactBatch& batch, std::vector<ContactImpulse>& out) {
  const World& world = state.world;
  const auto total = batch.total_impulses();
  const std::vector<double>& adhesive = state.rows.adhesive;
  for (const Manifold& m : state.contacts.manifolds) {
    if (!counts_here(world, m)) continue;
    Vec3 crossing = crossing_impulse_of(state, m);
    const Vec3 s = state.contacts.frame_of(m).s, t = m.normal.cross(s);
    for (std::uint32_t p = m.first; p < m.first + m.count; ++p) {
      const auto& [along_n, along_s, along_t] = total[p];
      const double net = adhesive.empty() ? along_n : along_n - adhesive[p];
      const Vec3 impulse = net * m.normal + along_s * s + along_t * t + std::exchange(crossing, Vec3::Zero());
      const Slot from = moves_freely(world, m.slot_a) ? m.slot_a : m.slot_b;  // as impacts are told (impacts.cpp)
      const Vec3 point = place_of(world, m, from) + arm_of(world, m, state.contacts.points[p], from);
      add_impulse(world, m, m.time > 0 ? point : state.contacts.points[p].position, m.normal, impulse, out);
    }
  }
}

// The place of a side of a surface's contact: the mean of its ends by their shares.
Vec3 side_of(const World& world, const SurfaceContact& contact, bool first) {
  Vec3 mean = Vec3::Zero();
  for (std::size_t k = 0; k < 4; ++k)
    if (contact.slots[k] >= 0 && (contact.weights[k] > 0) == first)
      mean += std::abs(contact.weights[k]) * world.position[static_cast<std::size_t>(contact.slots[k])];
  return mean;
}

void add_surfaces(const RankState& state, const SurfaceBatch& batch, std::vector<ContactImpulse>& out) {
  const World& world = state.world;
  std::vector<Vec3> total(state.contacts.surface.size());
  batch.total_impulses(total);
  for (std::size_t i = 0; i < total.size(); ++i) {
    const SurfaceContact& contact = state.contacts.surface[i];
    if (total[i].isZero(0) || !counts_here(world, contact)) continue;
    ContactImpulse& c = out.emplace_back();
    c.ids = contact.ids, c.shares = contact.weights;
    c.normal = contact.normal, c.friction = contact.friction, c.impulse = total[i];
    c.sides = {side_of(world, contact, true), side_of(world, contact, false)};
    c.point = c.sides[0] + contact.arm;
    const Slot body = contact.slots[0];
    if (!moves_freely(world, body)) c.sides[contact.weights[0] > 0 ? 0 : 1] = c.point;
  }
}

}  // namespace

void add_impulse(const World& world, const Manifold& manifold, const Vec3& point, const Vec3& normal, const Vec3& impulse,
                 std::vector<ContactImpulse>& out) {
  if (impulse.isZero(0)) return;
  const Vec3 into_cell = -world.period.shift(world.period.image_of(point)), place = point + into_cell;
  const auto side = [&](Slot slot) { return moves_freely(world, slot) ? place_of(world, manifold, slot) + into_cell : place; };
  out.push_back({{manifold.id_a, manifold.id_b, -1, -1},
                 {1, -1, 0, 0},
                 place,
                 {side(manifold.slot_a), side(manifold.slot_b)},
                 normal,
                 impulse,
                 manifold.friction});
}

std::vector<ContactImpulse> contact_impulses(const RankState& state, const System& system) {
  std::vector<ContactImpulse> out = state.impacts.impulses;
  add_bodies(state, system.contacts(), out);
  if (!state.contacts.surface.empty()) add_surfaces(state, system.batch<SurfaceBatch>(), out);
  return out;
}

}  // namespace unibody
