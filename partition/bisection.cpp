#include "partition/bisection.hpp"

#include <algorithm>
#include <bit>
#include <limits>
#include <numeric>

#include "core/checked.hpp"

namespace unibody {

namespace {

constexpr std::size_t axes = 3;
constexpr int bits_at_once = 4;

}  // namespace

Bisection::Bisection(MPI_Comm comm, std::span<const Place> cells, std::span<const std::int64_t> weights,
                     std::span<const int> shares) {
  Node& root = nodes_.emplace_back(Node{0, static_cast<int>(shares.size())});
  root.cells.resize(cells.size());
  std::iota(root.cells.begin(), root.cells.end(), std::size_t{0});
  for (std::size_t first = 0; first < nodes_.size();) {
    const std::size_t end = nodes_.size();
    std::vector<Node> level;  // that are cut
    for (std::size_t n = first; n < end; ++n)
      if (nodes_[n].parts > 1) level.push_back(std::move(nodes_[n]));
    find_sides(comm, level, cells);
    find_cuts(comm, level, cells, weights, shares);
    std::size_t next = 0;
    for (std::size_t n = first; n < end; ++n) {
      if (nodes_[n].parts == 1) continue;
      Node& node = level[next++];
      node.children = nodes_.size();
      const int below = node.parts / 2;
      Node children[2] = {{node.first_part, below}, {node.first_part + below, node.parts - below}};
      for (const std::size_t c : node.cells) children[key_of(node, cells[c]) >= node.cut].cells.push_back(c);
      node.cells = {}, node.order = {}, node.sum = {};
      nodes_[n] = std::move(node);
      for (Node& child : children) nodes_.push_back(std::move(child));
    }
    first = end;
  }
}

int Bisection::part_of(const Place& cell) const {
  const Node* node = &nodes_.front();
  while (node->parts > 1) node = &nodes_[node->children + (key_of(*node, cell) >= node->cut ? 1 : 0)];
  return node->first_part;
}

// A place without a cell may lie outside of the node's sides: it is moved to them.
Bisection::Key Bisection::key_of(const Node& node, const Place& cell) {
  Key key = 0;
  for (std::size_t k = 0; k < axes; ++k) {
    const std::size_t axis = (static_cast<std::size_t>(node.axis) + k) % axes;
    const std::int64_t at = std::int64_t{std::clamp(cell[axis], node.low[axis], node.high[axis])} - node.low[axis];
    key = key << node.bits | static_cast<Key>(at);
  }
  return key;
}

void Bisection::find_sides(MPI_Comm comm, std::span<Node> level, std::span<const Place> cells) {
  std::vector<std::int64_t> reach(2 * axes * level.size(), std::numeric_limits<std::int64_t>::min());  // and of the negatives
  for (std::size_t n = 0; n < level.size(); ++n)
    for (const std::size_t c : level[n].cells)
      for (std::size_t k = 0; k < axes; ++k) {
        std::int64_t* const side = &reach[2 * (axes * n + k)];
        side[0] = std::max<std::int64_t>(side[0], cells[c][k]), side[1] = std::max(side[1], -std::int64_t{cells[c][k]});
      }
  if (!reach.empty()) check_mpi(MPI_Allreduce(MPI_IN_PLACE, reach.data(), mpi_count(reach.size()), MPI_INT64_T, MPI_MAX, comm));
  for (std::size_t n = 0; n < level.size(); ++n) {
    Node& node = level[n];
    std::uint64_t longest = 0;
    for (std::size_t k = 0; k < axes; ++k) {
      const std::int64_t* const side = &reach[2 * (axes * n + k)];
      if (side[0] < -side[1] || side[0] == std::numeric_limits<std::int64_t>::min()) continue;  // no cell anywhere
      node.low[k] = static_cast<std::int32_t>(-side[1]), node.high[k] = static_cast<std::int32_t>(side[0]);
      const auto length = static_cast<std::uint64_t>(side[0] + side[1]);
      if (length > longest) longest = length, node.axis = static_cast<int>(k);
    }
    node.bits = std::max(1, static_cast<int>(std::bit_width(longest)));
  }
}

std::int64_t Bisection::weight_before(const Node& node, Key key) {
  const auto at = std::ranges::lower_bound(node.order, key, {}, &Weighed::key);
  return node.sum[static_cast<std::size_t>(at - node.order.begin())];
}

void Bisection::find_cuts(MPI_Comm comm, std::span<Node> level, std::span<const Place> cells,
                          std::span<const std::int64_t> weights, std::span<const int> shares) {
  if (level.empty()) return;
  std::vector<std::int64_t> total;
  int bits = 1;  // the same for all, so that they are found in as many turns
  for (const Node& node : level) bits = std::max(bits, node.bits);
  for (Node& node : level) {
    node.bits = bits;
    for (const std::size_t c : node.cells) node.order.push_back({key_of(node, cells[c]), weights[c]});
    std::ranges::sort(node.order, {}, &Weighed::key);
    node.sum.assign(1, 0);
    for (const Weighed& w : node.order) node.sum.push_back(node.sum.back() + w.weight);
    total.push_back(node.sum.back());
  }
  check_mpi(MPI_Allreduce(MPI_IN_PLACE, total.data(), mpi_count(total.size()), MPI_INT64_T, MPI_SUM, comm));
  for (std::size_t n = 0; n < level.size(); ++n) {
    const auto of_node = shares.subspan(static_cast<std::size_t>(level[n].first_part), static_cast<std::size_t>(level[n].parts));
    const auto below = of_node.first(static_cast<std::size_t>(level[n].parts / 2));
    const auto sum = [](std::span<const int> list) { return std::accumulate(list.begin(), list.end(), std::int64_t{0}); };
    level[n].target =
        static_cast<std::int64_t>(static_cast<Key>(total[n]) * static_cast<Key>(sum(below)) / static_cast<Key>(sum(of_node)));
  }
  for (int left = static_cast<int>(axes) * bits; left > 0;) {
    const int turn = std::min(left, bits_at_once);
    left -= turn;
    refine(comm, level, left, std::size_t{1} << turn);
  }
  for (Node& node : level)  // before or behind the cell that the target lies in
    if (node.target - node.before > node.before + node.within - node.target) ++node.cut;
}

// The stretch of keys where each cut lies becomes one of its own `stretches`, of 2^bits keys each.
void Bisection::refine(MPI_Comm comm, std::span<Node> level, int bits, std::size_t stretches) {
  std::vector<std::int64_t> weight;
  for (const Node& node : level)
    for (std::size_t s = 0; s < stretches; ++s)
      weight.push_back(weight_before(node, node.cut + (static_cast<Key>(s + 1) << bits)) -
                       weight_before(node, node.cut + (static_cast<Key>(s) << bits)));
  check_mpi(MPI_Allreduce(MPI_IN_PLACE, weight.data(), mpi_count(weight.size()), MPI_INT64_T, MPI_SUM, comm));
  for (std::size_t n = 0; n < level.size(); ++n) {
    Node& node = level[n];
    const std::int64_t* const of_node = &weight[n * stretches];
    std::size_t s = 0;
    for (; s + 1 < stretches && node.before + of_node[s] < node.target; ++s) node.before += of_node[s];
    node.within = of_node[s];
    node.cut += static_cast<Key>(s) << bits;
  }
}

}  // namespace unibody
