#include "partition/cell_graph.hpp"

#include <metis.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <numeric>
#include <tuple>
#include <unordered_map>

#include "core/errors.hpp"
#include "partition/bisection.hpp"

namespace unibody {

Cell cell_at(const Vec3& p, double edge) {
  const auto index = [&](double x) { return static_cast<std::int32_t>(std::floor(std::clamp(x / edge, -1e9, 1e9))); };
  return {index(p.x()), index(p.y()), index(p.z()), 0, 0};
}

std::vector<Cell> merge(std::vector<Cell> cells) {
  std::ranges::sort(cells, {}, [](const Cell& c) { return std::tuple(c.place(), -c.weight, c.owner); });
  std::size_t n = 0;
  for (const Cell& c : cells)
    if (n > 0 && cells[n - 1].place() == c.place())
      cells[n - 1].weight += c.weight;
    else
      cells[n++] = c;
  cells.resize(n);
  return cells;
}

const Cell* find_cell(std::span<const Cell> sorted, const Cell& cell) {
  const auto at = std::ranges::lower_bound(sorted, cell.place(), {}, &Cell::place);
  return at != sorted.end() && at->place() == cell.place() ? &*at : nullptr;
}

namespace {

// The graph of cells that share a face, edge weights the smaller of the two cells' weights: a guess at the contacts between them.
struct Graph {
  std::vector<idx_t> begin, neighbour, edge_weight, node_weight;
};

// Patches are neighbours where constraints tie them together, cells where joints do.
using Links = std::map<std::pair<std::size_t, std::size_t>, float>;

Links links_between(const std::vector<Cell>& cells, std::span<const CellLink> links) {
  Links result;
  const auto find = [&](const Cell& cell) {
    const Cell* const found = find_cell(cells, cell);
    return found != nullptr ? static_cast<std::size_t>(found - cells.data()) : cells.size();
  };
  for (const CellLink& link : links) {
    const std::size_t a = find(link.a), b = find(link.b);
    if (a == b || a >= cells.size() || b >= cells.size()) continue;
    result[{a, b}] += link.weight, result[{b, a}] += link.weight;
  }
  return result;
}

// METIS adds up the weights of all nodes and of all edges as idx_t, without looking whether they fit. So the weights are whole
// multiples of a unit so large that the sums stay below this; at least 1, which few cells come to.
constexpr double most_weight = 1 << 28;

std::vector<idx_t> in_units(std::span<const double> weights, double unit) {
  std::vector<idx_t> whole;
  for (const double w : weights) whole.push_back(std::max<idx_t>(1, static_cast<idx_t>(std::lround(w / unit))));
  return whole;
}

Graph graph_of(const std::vector<Cell>& cells, const Links& links) {
  Graph g;
  std::vector<double> node_weight, edge_weight;
  for (const Cell& c : cells) node_weight.push_back(c.weight);
  const double total = std::accumulate(node_weight.begin(), node_weight.end(), 0.0);
  const double heaviest = *std::max_element(node_weight.begin(), node_weight.end());
  const double unit = std::max({1e-30, heaviest / 1000, total / most_weight});
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const std::size_t first = g.neighbour.size();
    g.begin.push_back(static_cast<idx_t>(first));
    for (auto it = links.lower_bound({i, 0}); it != links.end() && it->first.first == i; ++it) {
      g.neighbour.push_back(static_cast<idx_t>(it->first.second));
      edge_weight.push_back(it->second);
    }
    if (cells[i].is_patch()) continue;
    for (int axis = 0; axis < 3; ++axis)
      for (const int step : {-1, 1}) {
        Cell other = cells[i];
        (axis == 0 ? other.x : axis == 1 ? other.y : other.z) += step;
        const Cell* const found = find_cell(cells, other);
        if (found == nullptr) continue;
        const auto j = static_cast<std::size_t>(found - cells.data());
        const double weight = std::min(node_weight[i], node_weight[j]);
        const auto linked =
            std::find(g.neighbour.begin() + static_cast<std::ptrdiff_t>(first), g.neighbour.end(), static_cast<idx_t>(j));
        if (linked != g.neighbour.end()) {
          edge_weight[static_cast<std::size_t>(linked - g.neighbour.begin())] += weight;
          continue;
        }
        g.neighbour.push_back(static_cast<idx_t>(j));
        edge_weight.push_back(weight);
      }
  }
  g.begin.push_back(static_cast<idx_t>(g.neighbour.size()));
  g.node_weight = in_units(node_weight, unit);
  const double all_edges = std::accumulate(edge_weight.begin(), edge_weight.end(), 0.0);
  g.edge_weight = in_units(edge_weight, std::max(unit, all_edges / most_weight));
  return g;
}

// Whether a part weighs more than twice the mean and a cell beside, which no balanced cut needs.
bool is_lopsided(const std::vector<Cell>& cells, std::span<const idx_t> part, int parts) {
  std::vector<double> load(static_cast<std::size_t>(parts), 0);
  double total = 0, heaviest = 0;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    load[static_cast<std::size_t>(part[i])] += cells[i].weight;
    total += cells[i].weight, heaviest = std::max<double>(heaviest, cells[i].weight);
  }
  return *std::max_element(load.begin(), load.end()) > 2 * total / parts + heaviest;
}

std::vector<idx_t> cut_by_metis(const std::vector<Cell>& cells, std::span<const CellLink> links, int parts) {
  std::vector<idx_t> part(cells.size());
  // Six neighbours a cell, and the ends of each link, are numbered by idx_t.
  if (6 * cells.size() + 2 * links.size() > static_cast<std::size_t>(std::numeric_limits<idx_t>::max()))
    throw RunError(std::to_string(cells.size()) + " cells are more than METIS can number");
  Graph g = graph_of(cells, links_between(cells, links));
  auto nodes = static_cast<idx_t>(cells.size());
  idx_t constraints = 1, count = parts, edge_cut = 0, options[METIS_NOPTIONS];
  if (METIS_SetDefaultOptions(options) != METIS_OK) throw RunError("METIS has no default options");
  options[METIS_OPTION_SEED] = 1;
  options[METIS_OPTION_UFACTOR] = 10;  // 1 % imbalance
  options[METIS_OPTION_NCUTS] = 4;
  const auto method = parts <= 8 ? METIS_PartGraphRecursive : METIS_PartGraphKway;
  const int status = method(&nodes, &constraints, g.begin.data(), g.neighbour.data(), g.node_weight.data(), nullptr,
                            g.edge_weight.data(), &count, nullptr, nullptr, options, &edge_cut, part.data());
  if (status != METIS_OK)
    throw RunError("METIS failed with status " + std::to_string(status) + " on a graph of " + std::to_string(cells.size()) +
                   " cells");
  if (is_lopsided(cells, part, parts)) throw RunError("METIS leaves a part with more than twice its share of the work");
  return part;
}

// No result depends on how the bodies are cut: where METIS fails the run goes on with a plainer cut, and says so.
std::vector<idx_t> cut(const std::vector<Cell>& cells, std::span<const CellLink> links, int parts) {
  std::vector<idx_t> part(cells.size());
  if (cells.size() <= static_cast<std::size_t>(parts)) {  // METIS wants more nodes than parts
    std::iota(part.begin(), part.end(), 0);
    return part;
  }
  try {
    return cut_by_metis(cells, links, parts);
  } catch (const RunError& error) {
    std::fprintf(stderr, "unibody: %s: the bodies are divided among the ranks by planes instead\n", error.what());
  }
  std::vector<Bisection::Place> places;
  std::vector<std::int64_t> weights;
  for (const Cell& c : cells) places.push_back(c.place()), weights.push_back(c.whole_weight());
  const Bisection planes(MPI_COMM_SELF, places, weights, std::vector<int>(static_cast<std::size_t>(parts), 1));
  std::ranges::transform(cells, part.begin(), [&](const Cell& c) { return planes.part_of(c.place()); });
  return part;
}

// Renames the parts so that each rank keeps the part it holds most of already, heaviest overlap first. The part p is going to
// rank first_owner + p.
void rename_parts(const std::vector<Cell>& cells, std::vector<idx_t>& part, int parts, int first_owner) {
  const auto n = static_cast<std::size_t>(parts);
  std::unordered_map<std::uint64_t, double> overlap;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const int there = cells[i].owner - first_owner;
    if (there >= 0 && there < parts)
      overlap[static_cast<std::uint64_t>(part[i]) * n + static_cast<std::uint64_t>(there)] += cells[i].weight;
  }
  std::vector<std::pair<double, std::uint64_t>> heaviest;
  heaviest.reserve(overlap.size());
  for (const auto& [key, weight] : overlap) heaviest.emplace_back(-weight, key);
  std::sort(heaviest.begin(), heaviest.end());
  std::vector<idx_t> rank_of(n, -1);
  std::vector<std::uint8_t> taken(n, 0);
  for (const auto& [weight, key] : heaviest) {
    const auto p = static_cast<std::size_t>(key / n), r = static_cast<std::size_t>(key % n);
    if (rank_of[p] < 0 && !taken[r]) rank_of[p] = static_cast<idx_t>(r), taken[r] = 1;
  }
  for (std::size_t p = 0, free = 0; p < n; ++p) {
    if (rank_of[p] >= 0) continue;
    while (taken[free]) ++free;
    rank_of[p] = static_cast<idx_t>(free), taken[free] = 1;
  }
  for (idx_t& p : part) p = rank_of[static_cast<std::size_t>(p)];
}

}  // namespace

std::vector<int> cut_cells(const std::vector<Cell>& cells, std::span<const CellLink> links, int parts, int first_owner) {
  if (parts == 1 || cells.empty()) return std::vector<int>(cells.size(), 0);
  std::vector<idx_t> part = cut(cells, links, parts);
  rename_parts(cells, part, parts, first_owner);
  return {part.begin(), part.end()};
}

}  // namespace unibody
