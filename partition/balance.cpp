#include "partition/balance.hpp"

#include <algorithm>

#include "partition/partition.hpp"

namespace unibody {

namespace {

// Work of a body beside that of its contact points, in points: prediction, broad phase, bookkeeping.
constexpr float cost_of_a_body = 2;

// Cells hold some ten bodies of the common size: coarse enough for a small graph, fine enough for an even cut.
constexpr double cell_in_radii = 4;

double mean_bounding_radius(MPI_Comm comm, const World& world) {
  double sum[2] = {0, static_cast<double>(world.homes)}, total[2] = {0, 0};
  for (std::size_t i = 0; i < world.homes; ++i) sum[0] += bounding_radius(world.properties[i].shape);
  MPI_Reduce(sum, total, 2, MPI_DOUBLE, MPI_SUM, 0, comm);
  MPI_Bcast(total, 2, MPI_DOUBLE, 0, comm);
  return total[1] > 0 ? total[0] / total[1] : 1;
}

}  // namespace

std::vector<int> Balance::homes(const World& world, const Contacts& contacts) const {
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
  return partition_bodies(comm_, {world.position.data(), world.homes}, cost, cell_in_radii * mean_bounding_radius(comm_, world));
}

double Balance::imbalance(const World& world, const Contacts& contacts) {
  int ranks = 1;
  MPI_Comm_size(comm_, &ranks);
  if (ranks == 1) return 1;
  const auto work = static_cast<std::int64_t>(contacts.points.size() + static_cast<std::size_t>(cost_of_a_body) * world.homes);
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
