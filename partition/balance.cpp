#include "partition/balance.hpp"

#include <algorithm>
#include <map>
#include <tuple>

#include "constraints/constraint_types.hpp"
#include "core/checked.hpp"
#include "partition/partition.hpp"

namespace unibody {

namespace {

// Cells hold some ten bodies of the common size: coarse enough for a small graph, fine enough for an even cut.
constexpr double cell_in_radii = 4;

double mean_bounding_radius(MPI_Comm comm, const World& world, std::span<const Patch> patches) {
  double sum[2] = {0, 0}, total[2] = {0, 0};
  for (std::size_t i = 0; i < world.homes; ++i)
    if (patches[i].group < 0) sum[0] += bounding_radius(world.properties[i].shape), sum[1] += 1;
  check_mpi(MPI_Reduce(sum, total, 2, MPI_DOUBLE, MPI_SUM, 0, comm));
  check_mpi(MPI_Bcast(total, 2, MPI_DOUBLE, 0, comm));
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
    const auto cost = static_cast<float>(cost_of_type(list));
    for (const auto& c : list) {
      const Patch first = patch_of(c.ids[0]);
      for (std::size_t e = 1; e < c.ids.size(); ++e) {
        const Patch other = patch_of(c.ids[e]);
        if (first.group < 0 || other.group < 0 || (first.group == other.group && first.number == other.number)) continue;
        found[{first, other, 0}] += cost;
      }
    }
  });
  std::vector<PatchLink> result;
  result.reserve(found.size());
  for (const auto& [link, weight] : found) result.push_back({link.a, link.b, weight});
  return result;
}

// The joints whose two bodies are known here (at the start a few are not): what a cut between them costs.
std::vector<PlaceLink> Balance::ties(const StepParts& parts) {
  const World& world = parts.world;
  std::vector<PlaceLink> tied;
  for (const std::int64_t number : parts.joints_here) {
    const Joint& joint = parts.joints[static_cast<std::size_t>(number)];
    const Slot a = world.find(joint.ids[0]), b = joint.ids[1] < 0 ? -1 : world.find(joint.ids[1]);
    if (a < 0 || b < 0 || world.is_static(a) || world.is_static(b)) continue;
    const auto place = [&](Slot slot) { return world.period.wrapped(world.position[static_cast<std::size_t>(slot)]); };
    tied.push_back({place(a), place(b), static_cast<float>(cost_of(joint))});
  }
  return tied;
}

std::vector<int> Balance::homes(const StepParts& parts) const {
  const World& world = parts.world;
  int ranks = 1;
  check_mpi(MPI_Comm_size(comm_, &ranks));
  if (seed_) {
    std::vector<int> home(world.homes);
    for (std::size_t i = 0; i < world.homes; ++i) home[i] = random_home(world.id[i], *seed_, ranks);
    return home;
  }
  if (ranks == 1) return std::vector<int>(world.homes, 0);
  std::vector<Patch> patches(world.homes);
  for (std::size_t i = 0; i < world.homes && !groups_.empty(); ++i) patches[i] = patch_of(world.id[i]);
  const std::vector<PatchLink> between = parts.constraints != nullptr ? links(*parts.constraints) : std::vector<PatchLink>{};
  const double cell = cell_in_radii * mean_bounding_radius(comm_, world, patches);
  std::vector<Vec3> places(world.position.begin(), world.position.begin() + static_cast<std::ptrdiff_t>(world.homes));
  for (Vec3& place : places) place = world.period.wrapped(place);
  return partition_bodies(comm_, places, work_by_body(parts), cell, patches, between, ties(parts));
}

double Balance::imbalance(const StepParts& parts) {
  const World& world = parts.world;
  int ranks = 1;
  check_mpi(MPI_Comm_size(comm_, &ranks));
  if (ranks == 1) return 1;
  const auto work = static_cast<std::int64_t>(work_of(parts));
  std::int64_t sums[3] = {work, static_cast<std::int64_t>(world.homes), static_cast<std::int64_t>(world.guests)}, most = work;
  check_mpi(MPI_Allreduce(MPI_IN_PLACE, sums, 3, MPI_INT64_T, MPI_SUM, comm_));
  check_mpi(MPI_Allreduce(MPI_IN_PLACE, &most, 1, MPI_INT64_T, MPI_MAX, comm_));
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
