#include "step/adhesion.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "step/liquid.hpp"

namespace unibody {

namespace {

constexpr double automatic_range = 0.01;  // of the smaller body's size

struct Attraction {
  double force, range;  // N, m
};

// Where surfaces have energy, two bodies come apart at the force that Johnson, Kendall and Roberts found (Proceedings of the
// Royal Society A 324, 1971), 3/2 pi gamma R, which does not depend on how stiff the bodies are.
Attraction attraction_of(const RankState& state, const Manifold& m) {
  const BodyProperties &a = state.world.properties[static_cast<std::size_t>(m.slot_a)],
                       &b = state.world.properties[static_cast<std::size_t>(m.slot_b)];
  const auto of = [&](PairValue value) { return state.scene.pairs.of(value, a.material, b.material); };
  const double range = of(PairValue::adhesion_range), smaller = std::min(smallest_size(a.shape), smallest_size(b.shape));
  return {of(PairValue::adhesion) + 1.5 * M_PI * of(PairValue::surface_energy) * reduced_radius(a.shape, b.shape),
          range > 0 ? range : automatic_range * smaller};
}

// The pair's points within the range, of its manifolds [first, end). A ring inside of a face is no contact of its own.
template <class F>
void for_each_near(const Contacts& contacts, std::size_t first, std::size_t end, double range, F&& f) {
  for (std::size_t i = first; i < end; ++i) {
    const Manifold& m = contacts.manifolds[i];
    for (std::uint32_t p = m.first; p < m.first + m.count && !m.is_inner_ring; ++p)
      if (contacts.points[p].gap <= range) f(p);
  }
}

}  // namespace

std::vector<double> adhesive_impulses(const RankState& state) {
  if (!state.traits.adheres) return {};
  const Contacts& contacts = state.contacts;
  std::vector<double> impulses(contacts.points.size(), 0.0);
  for (std::size_t i = 0, end = 0; i < contacts.manifolds.size(); i = end) {
    const Manifold& m = contacts.manifolds[i];
    while (end < contacts.manifolds.size() && contacts.manifolds[end].id_a == m.id_a && contacts.manifolds[end].id_b == m.id_b)
      ++end;
    const auto pull = [&](double force, double range) {
      if (!(force > 0)) return;
      int count = 0;
      for_each_near(contacts, i, end, range, [&](std::uint32_t) { ++count; });
      for_each_near(contacts, i, end, range, [&](std::uint32_t p) { impulses[p] += state.step() * force / count; });
    };
    const Attraction pair = attraction_of(state, m);
    pull(pair.force, pair.range);
    double gap = std::numeric_limits<double>::infinity();
    for_each_near(contacts, i, end, gap, [&](std::uint32_t p) { gap = std::min(gap, contacts.points[p].gap); });
    const BridgePull bridge = bridge_pull(state, m, gap);
    pull(bridge.force, bridge.reach);
  }
  return impulses;
}

void attract(const RankState& state, System& system) {
  const std::vector<double>& impulses = state.rows.adhesive;
  if (impulses.empty()) return;
  const World& world = state.world;
  for (const Manifold& m : state.contacts.manifolds)
    for (const Slot slot : {m.slot_a, m.slot_b}) {
      const auto i = static_cast<std::size_t>(slot);
      SolverBody& body = system.bodies[i];
      if (!world.is_home(slot) || !(body.inverse_mass > 0)) continue;
      Vec3 impulse = Vec3::Zero(), moment = Vec3::Zero();
      for (std::uint32_t p = m.first; p < m.first + m.count; ++p) {
        const Vec3 pull = (slot == m.slot_a ? -impulses[p] : impulses[p]) * m.normal;
        impulse += pull, moment += arm_of(world, m, state.contacts.points[p], slot).cross(pull);
      }
      Eigen::Map<Vec3>(body.v) += body.inverse_mass * impulse;
      Eigen::Map<Vec3>(body.w) += inverse_inertia_of(system.bodies, system.inertia, system.isotropic, i) * moment;
    }
}

}  // namespace unibody
