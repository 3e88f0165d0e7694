#include "partition/partition.hpp"

#include <algorithm>
#include <map>
#include <optional>

#include "core/checked.hpp"
#include "core/hash.hpp"
#include "partition/bisection.hpp"
#include "partition/cell_graph.hpp"
#include "partition/messages.hpp"

namespace unibody {

namespace {

constexpr int tag_cells = 131, tag_links = 132, tag_parts = 133, tag_patches = 134, tag_centres = 135;

Cell cell_of(const Patch& p) { return {p.number, p.group, patch_layer, 0, 0}; }

// Ranks [first(g), first(g + 1)) share group g.
struct Groups {
  int count, ranks;
  int first(int group) const { return static_cast<int>(std::int64_t{ranks} * group / count); }
};

// What is known here of a patch: the weight of its nodes, and their places times their weights.
struct PatchSum {
  Patch patch;
  double weight = 0;
  Vec3 moment = Vec3::Zero();
};
struct PatchCentre {
  Patch patch;
  Cell cell;  // of space, where the middle of the patch lies
};

// Collective. Where the patches lie that this rank has nodes of, or links to.
std::map<Patch, Cell> patch_centres(MPI_Comm comm, const std::map<Patch, PatchSum>& sums, double edge) {
  int ranks = 1;
  check_mpi(MPI_Comm_size(comm, &ranks));
  const auto keeper = [&](const Patch& p) {
    return static_cast<int>(Hash().add(std::int64_t{p.group}).add(std::int64_t{p.number}).value() %
                            static_cast<std::uint64_t>(ranks));
  };
  ListsByRank<PatchSum> to;
  for (const auto& [patch, sum] : sums) to[keeper(patch)].push_back(sum);
  const auto from = exchange_lists(comm, to, tag_patches);
  std::map<Patch, PatchSum> whole;
  for (const auto& [rank, list] : from)
    for (const PatchSum& part : list) {
      PatchSum& sum = whole[part.patch];
      sum.weight += part.weight, sum.moment += part.moment;
    }
  ListsByRank<PatchCentre> answers;
  for (const auto& [rank, list] : from)
    for (const PatchSum& asked : list) {
      const PatchSum& sum = whole[asked.patch];
      answers[rank].push_back({asked.patch, cell_at(sum.moment / std::max(1e-30, sum.weight), edge)});
    }
  std::map<Patch, Cell> centres;
  for (const PatchCentre& centre : joined(exchange_lists(comm, answers, tag_centres))) centres[centre.patch] = centre.cell;
  return centres;
}

// Which group each cell goes to.
class Grouping {
 public:
  // centres: of the patches among the cells, and among those to be asked for.
  Grouping(MPI_Comm comm, const Groups& groups, const std::vector<Cell>& mine, std::map<Patch, Cell> centres)
      : centres_(std::move(centres)) {
    if (groups.count == 1) return;
    std::vector<Bisection::Place> places;
    std::vector<std::int64_t> weights;
    for (const Cell& c : mine) places.push_back(in_space(c)), weights.push_back(c.whole_weight());
    std::vector<int> shares;
    for (int g = 0; g < groups.count; ++g) shares.push_back(groups.first(g + 1) - groups.first(g));
    planes_.emplace(comm, places, weights, shares);
  }

  int operator()(const Cell& c) const { return planes_ ? planes_->part_of(in_space(c)) : 0; }

 private:
  Bisection::Place in_space(const Cell& c) const { return c.is_patch() ? centres_.at({c.y, c.x}).place() : c.place(); }

  std::map<Patch, Cell> centres_;
  std::optional<Bisection> planes_;
};

// Collective. As many groups as the limits ask for; a cell that lies on two ranks is counted twice.
Groups groups_for(MPI_Comm comm, std::size_t cells_here, const GroupLimits& limits) {
  Groups groups{1, 1};
  check_mpi(MPI_Comm_size(comm, &groups.ranks));
  auto cells = static_cast<std::int64_t>(cells_here);
  check_mpi(MPI_Allreduce(MPI_IN_PLACE, &cells, 1, MPI_INT64_T, MPI_SUM, comm));
  const std::int64_t by_parts = (groups.ranks + limits.parts - 1) / limits.parts,
                     by_cells = (cells + limits.cells - 1) / limits.cells;
  groups.count = static_cast<int>(std::clamp<std::int64_t>(std::max(by_parts, by_cells), 1, groups.ranks));
  return groups;
}

// Collective. The new owners of this rank's cells: each group's cells are cut on the first of its ranks, which answers.
void find_owners(MPI_Comm comm, const Groups& groups, const Grouping& group_of, std::vector<Cell>& mine,
                 std::span<const CellLink> links) {
  ListsByRank<Cell> to;
  for (const Cell& c : mine) to[groups.first(group_of(c))].push_back(c);
  ListsByRank<CellLink> links_to;
  for (const CellLink& link : links) {
    const int group = group_of(link.a);
    if (group == group_of(link.b)) links_to[groups.first(group)].push_back(link);
  }
  const auto from = exchange_lists(comm, to, tag_cells);
  const std::vector<CellLink> all_links = joined(exchange_lists(comm, links_to, tag_links));

  std::vector<Cell> all = merge(joined(from));
  ListsByRank<std::int32_t> answers;
  if (!all.empty()) {
    int first = 0;
    check_mpi(MPI_Comm_rank(comm, &first));
    const int group = group_of(all.front());
    const std::vector<int> part = cut_cells(all, all_links, groups.first(group + 1) - first, first);
    for (std::size_t i = 0; i < all.size(); ++i) all[i].owner = first + part[i];
    for (const auto& [rank, cells] : from)
      for (const Cell& c : cells) answers[rank].push_back(find_cell(all, c)->owner);
  }
  const auto owners = exchange_lists(comm, answers, tag_parts);
  std::map<int, std::size_t> next;  // answers come in the order of the questions
  for (Cell& c : mine) {
    const int leader = groups.first(group_of(c));
    c.owner = owners.at(leader)[next[leader]++];
  }
}

}  // namespace

std::vector<int> partition_bodies(MPI_Comm comm, std::span<const Vec3> positions, std::span<const float> cost, double edge,
                                  std::span<const Patch> patches, std::span<const PatchLink> links,
                                  std::span<const PlaceLink> joints, const GroupLimits& limits) {
  int rank = 0, size = 1;
  check_mpi(MPI_Comm_rank(comm, &rank));
  check_mpi(MPI_Comm_size(comm, &size));
  if (size == 1) return std::vector<int>(positions.size(), 0);

  const auto cell = [&](std::size_t i) {
    return patches.empty() || patches[i].group < 0 ? cell_at(positions[i], edge) : cell_of(patches[i]);
  };
  std::vector<Cell> mine(positions.size());
  std::map<Patch, PatchSum> sums;
  for (std::size_t i = 0; i < positions.size(); ++i) {
    mine[i] = cell(i);
    mine[i].weight = cost[i], mine[i].owner = rank;
    if (!mine[i].is_patch()) continue;
    PatchSum& sum = sums.try_emplace(patches[i], PatchSum{patches[i]}).first->second;
    sum.weight += cost[i], sum.moment += cost[i] * positions[i];
  }
  mine = merge(std::move(mine));
  std::vector<CellLink> cell_links;
  for (const PatchLink& link : links) {
    cell_links.push_back({cell_of(link.a), cell_of(link.b), link.weight});
    for (const Patch& p : {link.a, link.b}) sums.try_emplace(p, PatchSum{p});
  }
  for (const PlaceLink& link : joints) cell_links.push_back({cell_at(link.a, edge), cell_at(link.b, edge), link.weight});

  const Groups groups = groups_for(comm, mine.size(), limits);
  const Grouping group_of(comm, groups, mine, groups.count > 1 ? patch_centres(comm, sums, edge) : std::map<Patch, Cell>{});
  find_owners(comm, groups, group_of, mine, cell_links);
  std::vector<int> home(positions.size());
  for (std::size_t i = 0; i < positions.size(); ++i) home[i] = find_cell(mine, cell(i))->owner;
  return home;
}

int random_home(Id id, std::uint64_t seed, int ranks) {
  std::uint64_t x = static_cast<std::uint64_t>(id) * 0x9e3779b97f4a7c15ULL + seed * 0xd1342543de82ef95ULL;
  x = (x ^ (x >> 31)) * 0xbf58476d1ce4e5b9ULL;
  x ^= x >> 29;
  return static_cast<int>(x % static_cast<std::uint64_t>(ranks));
}

}  // namespace unibody
