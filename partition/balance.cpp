#include "partition/balance.hpp"

#include <algorithm>
#include <map>
#include <tuple>

#include "constraints/constraint_types.hpp"
#include "partition/partition.hpp"

namespace unibody {

namespace {

// Work of a body beside that of its contact points, in points: prediction, broad phase, bookkeeping.
constexpr float cost_of_a_body = 2;

// Cells hold some ten bodies of the common size: coarse enough for a small graph, fine enough for an even cut.
constexpr double cell_in_radii = 4;

// Work of a constraint beside that of a contact point.
constexpr float cost_of_a_constraint = 0.5f;
constexpr float cost_of_a_joint = 8;

double mean_bounding_radius(MPI_Comm comm, const World& world, std::span<const Patch> patches) {
  double sum[2] = {0, 0}, total[2] = {0, 0};
  for (std::size_t i = 0; i < world.homes; ++i)
    if (patches[i].group < 0) sum[0] += bounding_radius(world.properties[i].shape), sum[1] += 1;
  MPI_Reduce(sum, total, 2, MPI_DOUBLE, MPI_SUM, 0, comm);
  MPI_Bcast(total, 2, MPI_DOUBLE, 0, comm);
  return total[1] > 0 ? total[0] / total[1] : 1;
}

}  // namespace

Patch Balance::patch_of(Id id) const {
  for (std::size_t g = 0; g < groups_.size(); ++g)
    if (id >= groups_[g].first && id < groups_[g].first + groups_[g].count)
      return {static_cast<std::int32_t>(g), static_cast<std::int32_t>(groups_[g].patch_of(id))};
  return {};
}

// What ties the patches of this rank's bodies to others.
std::vector<PatchLink> Balance::links(const ConstraintSet& constraints) const {
  const auto less = [](const PatchLink& a, const PatchLink& b) {
    return std::tie(a.a.group, a.a.number, a.b.group, a.b.number) < std::tie(b.a.group, b.a.number, b.b.group, b.b.number);
  };
  std::map<PatchLink, float, decltype(less)> found(less);
  for_each_type(constraints, [&](auto, const auto& list) {
    for (const auto& c : list) {
      const Patch first = patch_of(c.ids[0]);
      for (std::size_t e = 1; e < c.ids.size(); ++e) {
        const Patch other = patch_of(c.ids[e]);
        if (first.group < 0 || other.group < 0 || (first.group == other.group && first.number == other.number)) continue;
        found[{first, other, 0}] += cost_of_a_constraint;
      }
    }
  });
  std::vector<PatchLink> result;
  for (const auto& [link, weight] : found) result.push_back({link.a, link.b, weight});
  return result;
}

std::vector<int> Balance::homes(const World& world, const Contacts& contacts, const ConstraintSet* constraints,
                                std::span<const Joint> joints, const JointList& joints_here) const {
  int ranks = 1;
  MPI_Comm_size(comm_, &ranks);
  if (seed_) {
    std::vector<int> home(world.homes);
    for (std::size_t i = 0; i < world.homes; ++i) home[i] = random_home(world.id[i], *seed_, ranks);
    return home;
  }
  std::vector<float> cost(world.homes, cost_of_a_body);
  for (const Manifold& m : contacts.manifolds) {
    const bool shared = !world.is_static(m.slot_a) && !world.is_static(m.slot_b);
    const float share = static_cast<float>(m.count) * (shared ? 0.5f : 1.0f);
    for (const Slot s : {m.slot_a, m.slot_b})
      if (world.is_home(s)) cost[static_cast<std::size_t>(s)] += share;
  }
  std::vector<Patch> patches(world.homes);
  for (std::size_t i = 0; i < world.homes && !groups_.empty(); ++i) patches[i] = patch_of(world.id[i]);
  std::vector<PatchLink> between;
  if (constraints != nullptr && ranks > 1) {
    between = links(*constraints);
    for_each_type(*constraints, [&](auto, const auto& list) {
      for (const auto& c : list)
        for (const Id id : c.ids)
          if (const Slot s = world.find(id); s >= 0 && world.is_home(s))
            cost[static_cast<std::size_t>(s)] += cost_of_a_constraint / static_cast<float>(c.ids.size());
    });
  }
  std::vector<PlaceLink> tied;  // where both bodies are known here: at the start a few are not
  for (const std::int64_t number : joints_here) {
    const auto& ids = joints[static_cast<std::size_t>(number)].ids;
    const Slot ends[2] = {world.find(ids[0]), ids[1] < 0 ? -1 : world.find(ids[1])};
    for (const Slot s : ends)
      if (s >= 0 && world.is_home(s)) cost[static_cast<std::size_t>(s)] += cost_of_a_joint / 2;
    if (ends[0] >= 0 && ends[1] >= 0 && !world.is_static(ends[0]) && !world.is_static(ends[1]))
      tied.push_back({world.position[static_cast<std::size_t>(ends[0])], world.position[static_cast<std::size_t>(ends[1])],
                      cost_of_a_joint});
  }
  const double cell = cell_in_radii * mean_bounding_radius(comm_, world, patches);
  return partition_bodies(comm_, {world.position.data(), world.homes}, cost, cell, patches, between, tied);
}

double Balance::imbalance(const World& world, const Contacts& contacts, std::size_t constraint_count) {
  int ranks = 1;
  MPI_Comm_size(comm_, &ranks);
  if (ranks == 1) return 1;
  const auto work = static_cast<std::int64_t>(contacts.points.size() + static_cast<std::size_t>(cost_of_a_body) * world.homes +
                                              constraint_count / 2);
  std::int64_t sums[3] = {work, static_cast<std::int64_t>(world.homes), static_cast<std::int64_t>(world.guests)}, most = work;
  MPI_Allreduce(MPI_IN_PLACE, sums, 3, MPI_INT64_T, MPI_SUM, comm_);
  MPI_Allreduce(MPI_IN_PLACE, &most, 1, MPI_INT64_T, MPI_MAX, comm_);
  imbalance_ = sums[0] > 0 ? static_cast<double>(most) * ranks / static_cast<double>(sums[0]) : 1;
  guest_share_ = sums[1] > 0 ? static_cast<double>(sums[2]) / static_cast<double>(sums[1]) : 0;
  if (fresh_) imbalance_then_ = imbalance_, guest_share_then_ = guest_share_, fresh_ = false;
  return imbalance_;
}

// 5 % worse than what the last partition gave, or half as many guests again.
bool Balance::due() const {
  if (!rebalance_ || seed_) return false;
  return imbalance_ > std::max(1.05, imbalance_then_ + 0.05) || guest_share_ > 1.5 * guest_share_then_ + 0.05;
}

}  // namespace unibody
