#include "step/liquid.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/checked.hpp"

namespace unibody {

namespace {

constexpr double touching = 1e-4;  // of the reduced radius: a gap up to which bodies touch

struct Liquid {
  double volume = 0, tension = 0, angle = 0, radius = 0;  // m^3, N/m, rad, m
};

// The liquid between two bodies. Its volume is 0 where their materials have none, or where neither body is round.
Liquid liquid_of(const RankState& state, const Manifold& m) {
  const BodyProperties &a = state.world.properties[static_cast<std::size_t>(m.slot_a)],
                       &b = state.world.properties[static_cast<std::size_t>(m.slot_b)];
  const auto of = [&](PairValue value) { return state.scene.pairs.of(value, a.material, b.material); };
  const double radius = reduced_radius(a.shape, b.shape);
  if (!(radius > 0)) return {};
  return {of(PairValue::liquid_volume), of(PairValue::surface_tension), of(PairValue::contact_angle) * M_PI / 180, radius};
}

template <class List>
auto find_pair(const List& list, Id a, Id b, auto&& key_of) {
  const auto found = std::ranges::lower_bound(list, std::pair(a, b), {}, key_of);
  return found != list.end() && key_of(*found) == std::pair(a, b) ? found : list.end();
}

std::pair<Id, Id> key_of_record(const PairRecord<1>& record) { return {record.key[0], record.key[1]}; }

bool has_bridge(const PairHistory<1>& bridges, const Manifold& m) {
  return find_pair(bridges, m.id_a, m.id_b, key_of_record) != bridges.end();
}

// Whether one of the two pressed on the other in the last step.
bool pressed(const Multipliers& last, const Manifold& m) {
  const auto key_of = [](const RememberedManifold& r) { return std::pair(r.id_a, r.id_b); };
  const auto found = find_pair(last.manifolds, m.id_a, m.id_b, key_of);
  if (found == last.manifolds.end()) return false;
  return std::ranges::any_of(last.points_of(static_cast<std::size_t>(found - last.manifolds.begin())),
                             [](const RememberedPoint& p) { return p.normal > 0; });
}

}  // namespace

double rupture_distance(double volume, double angle) { return (1 + angle / 2) * std::cbrt(volume); }

double bridge_force(double reduced_radius, double gap, double volume, double tension, double angle) {
  const double radius = 2 * reduced_radius, apart = std::max(0.0, gap) * std::sqrt(radius / volume);
  return 2 * M_PI * radius * tension * std::cos(angle) / (1 + 1.05 * apart + 2.5 * apart * apart);
}

void renew_bridges(RankState& state) {
  if (!state.traits.is_wet) return;
  const Contacts& contacts = state.contacts;
  auto& bridges = state.history.of<LiquidBatch>();
  PairHistory<1> now;
  for (std::size_t i = 0, end = 0; i < contacts.manifolds.size(); i = end) {
    const Manifold& m = contacts.manifolds[i];
    double gap = std::numeric_limits<double>::infinity();
    for (; end < contacts.manifolds.size() && contacts.manifolds[end].id_a == m.id_a && contacts.manifolds[end].id_b == m.id_b;
         ++end)
      for (std::uint32_t p = contacts.manifolds[end].first; p < contacts.manifolds[end].first + contacts.manifolds[end].count;
           ++p)
        gap = std::min(gap, contacts.points[p].gap);
    const Liquid liquid = liquid_of(state, m);
    if (!(liquid.volume > 0)) continue;
    const bool touches = gap <= touching * liquid.radius || pressed(state.history.contacts(), m);
    if (gap <= rupture_distance(liquid.volume, liquid.angle) && (touches || has_bridge(bridges, m)))
      now.push_back({{m.id_a, m.id_b}, {liquid.volume}});
  }
  bridges = std::move(now);
}

BridgePull bridge_pull(const RankState& state, const Manifold& m, double gap) {
  if (!state.traits.is_wet || !has_bridge(state.history.of<LiquidBatch>(), m)) return {};
  const Liquid liquid = liquid_of(state, m);
  return {bridge_force(liquid.radius, gap, liquid.volume, liquid.tension, liquid.angle),
          rupture_distance(liquid.volume, liquid.angle)};
}

std::int64_t count_bridges(const RankState& state) {
  const World& world = state.world;
  std::int64_t count = 0;
  for (const PairRecord<1>& bridge : state.history.of<LiquidBatch>()) {
    const Slot a = world.find(bridge.key[0]), b = world.find(bridge.key[1]);
    const Slot counting = a >= 0 && world.is_static(a) ? b : a;
    count += counting >= 0 && world.is_home(counting);
  }
  check_mpi(MPI_Allreduce(MPI_IN_PLACE, &count, 1, MPI_INT64_T, MPI_SUM, state.comm()));
  return count;
}

}  // namespace unibody
