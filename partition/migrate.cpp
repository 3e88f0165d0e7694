#include "partition/migrate.hpp"

#include <algorithm>
#include <map>
#include <numeric>
#include <type_traits>

#include "core/assume.hpp"
#include "core/checked.hpp"
#include "partition/messages.hpp"
#include "world/world_faults.hpp"

namespace unibody {

namespace {

constexpr int tag_bodies = 141, tag_manifolds = 142, tag_points = 143, tag_places = 144, tag_creeps = 145;

// Rank to which the body is going, for home bodies; -1 for ids that are not home here.
int destination(const World& world, std::span<const int> home, Id id) {
  const auto end = world.id.begin() + static_cast<std::ptrdiff_t>(world.homes);
  const auto it = std::lower_bound(world.id.begin(), end, id);
  return it != end && *it == id ? home[static_cast<std::size_t>(it - world.id.begin())] : -1;
}

}  // namespace

Multipliers keep_own(const World& world, const Multipliers& all) {
  const std::vector<int> zero(world.homes, 0);
  std::vector<std::uint32_t> order(all.manifolds.size());
  std::iota(order.begin(), order.end(), 0);
  const auto key = [&](std::uint32_t i) { return std::pair(all.manifolds[i].id_a, all.manifolds[i].id_b); };
  std::sort(order.begin(), order.end(), [&](auto i, auto j) { return key(i) < key(j); });
  Multipliers own;
  for (std::size_t i = 0; i < order.size(); ++i) {
    if (i > 0 && key(order[i]) == key(order[i - 1])) continue;
    const RememberedManifold& m = all.manifolds[order[i]];
    if (destination(world, zero, m.id_a) < 0 && destination(world, zero, m.id_b) < 0) continue;
    own.append(all, order[i]);
  }
  return own;
}

void migrate(MPI_Comm comm, World& world, Multipliers& multipliers, std::span<const int> home) {
  // A pair's multipliers go wherever one of its bodies goes.
  std::map<int, Multipliers> out;
  for (std::size_t i = 0; i < multipliers.manifolds.size(); ++i) {
    const RememberedManifold& m = multipliers.manifolds[i];
    const int to_a = destination(world, home, m.id_a), to_b = destination(world, home, m.id_b);
    if (to_a >= 0) out[to_a].append(multipliers, i);
    if (to_b >= 0 && to_b != to_a) out[to_b].append(multipliers, i);
  }
  ListsByRank<Body> bodies;
  std::map<int, std::size_t> count;
  for (std::size_t i = 0; i < world.homes; ++i) ++count[home[i]];
  for (const auto& [rank, n] : count) bodies[rank].reserve(n);
  for (std::size_t i = 0; i < world.homes; ++i) bodies[home[i]].push_back(world.body(i));

  std::vector<Body> mine = joined(exchange_lists(comm, std::move(bodies), tag_bodies));
  std::sort(mine.begin(), mine.end(), [](const Body& a, const Body& b) { return a.id < b.id; });

  const auto exchange = [&](auto Multipliers::*list, int tag) {
    std::map<int, std::remove_reference_t<decltype(out[0].*list)>> lists;
    for (auto& [rank, multipliers_there] : out) lists[rank] = std::move(multipliers_there.*list);
    return exchange_lists(comm, std::move(lists), tag);
  };
  const auto manifolds = exchange(&Multipliers::manifolds, tag_manifolds);
  const auto points = exchange(&Multipliers::points, tag_points);
  const auto places = exchange(&Multipliers::places, tag_places);
  const auto creeps = exchange(&Multipliers::creeps, tag_creeps);
  Multipliers all;
  for (const auto& [rank, list] : manifolds) {
    const int sender = rank;
    const auto of_sender = [sender](const auto& lists) {
      const auto found = lists.find(sender);
      return found != lists.end() ? found->second : typename std::remove_reference_t<decltype(lists)>::mapped_type{};
    };
    const Multipliers from{list, of_sender(points), of_sender(creeps), of_sender(places)};
    for (std::size_t i = 0; i < from.manifolds.size(); ++i) all.append(from, i);
  }

  const std::size_t statics = world.size() - world.first_static();
  std::vector<Body> static_bodies(statics);
  for (std::size_t i = 0; i < statics; ++i) static_bodies[i] = world.body(world.first_static() + i);
  world.homes = mine.size(), world.guests = 0;
  world.resize(mine.size() + statics);
  for (std::size_t i = 0; i < mine.size(); ++i) world.set(i, mine[i]);
  for (std::size_t i = 0; i < statics; ++i) world.set(mine.size() + i, static_bodies[i]);
  multipliers = keep_own(world, all);
  assume([&] { return fault_of(world); });
}

}  // namespace unibody
