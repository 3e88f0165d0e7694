#include "meshes/weld.hpp"

#include <cmath>
#include <limits>
#include <unordered_map>

#include "meshes/sets.hpp"

namespace unibody {

namespace {

struct CellHash {
  std::size_t operator()(const std::array<std::int64_t, 3>& c) const {
    std::uint64_t h = static_cast<std::uint64_t>(c[0]) * 0x9e3779b97f4a7c15u;
    h = (h ^ h >> 29) + static_cast<std::uint64_t>(c[1]) * 0xc2b2ae3d27d4eb4fu;
    h = (h ^ h >> 31) + static_cast<std::uint64_t>(c[2]) * 0x165667b19e3779f9u;
    return static_cast<std::size_t>(h ^ h >> 32);
  }
};

// The nodes that stay, by the cells of a lattice as wide as the distance: what is near a place is in 27 of them, a few in each.
class Kept {
 public:
  explicit Kept(double distance) : distance_(distance) {}

  // The first node within the distance; -1: none.
  std::int32_t near(const Vec3& x, const std::vector<Vec3>& nodes) const {
    const auto at = cell_of(x);
    std::int32_t first = -1;
    for (std::int64_t i = -1; i <= 1; ++i)
      for (std::int64_t j = -1; j <= 1; ++j)
        for (std::int64_t k = -1; k <= 1; ++k) {
          const auto found = cells_.find({at[0] + i, at[1] + j, at[2] + k});
          if (found == cells_.end()) continue;
          for (const std::int32_t node : found->second)
            if ((nodes[static_cast<std::size_t>(node)] - x).norm() <= distance_ && (first < 0 || node < first)) first = node;
        }
    return first;
  }
  void add(std::int32_t node, const Vec3& x) { cells_[cell_of(x)].push_back(node); }

 private:
  std::array<std::int64_t, 3> cell_of(const Vec3& x) const {
    std::array<std::int64_t, 3> cell{};
    for (std::size_t k = 0; k < 3; ++k)
      cell[k] = static_cast<std::int64_t>(std::floor(std::clamp(x[static_cast<Eigen::Index>(k)] / distance_, -1e15, 1e15)));
    return cell;
  }
  double distance_;
  std::unordered_map<std::array<std::int64_t, 3>, std::vector<std::int32_t>, CellHash> cells_;
};

std::string counted(std::int64_t count, const std::string& what) {
  return std::to_string(count) + " " + what + (count == 1 ? "" : "s");
}

}  // namespace

double extent_of(const std::vector<Vec3>& nodes) {
  if (nodes.empty()) return 0;
  Vec3 lower = nodes[0], upper = nodes[0];
  for (const Vec3& x : nodes) lower = lower.cwiseMin(x), upper = upper.cwiseMax(x);
  return (upper - lower).maxCoeff();
}

std::vector<std::int32_t> weld(std::vector<Vec3>& nodes, double distance) {
  std::vector<std::int32_t> number(nodes.size());
  if (!(distance > 0) || !std::isfinite(distance)) {
    std::iota(number.begin(), number.end(), 0);
    return number;
  }
  Kept kept(distance);
  std::size_t count = 0;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    number[i] = kept.near(nodes[i], nodes);
    if (number[i] >= 0) continue;
    number[i] = static_cast<std::int32_t>(count);
    nodes[count] = nodes[i];
    kept.add(number[i], nodes[count++]);
  }
  nodes.resize(count);
  return number;
}

template <std::size_t n>
std::int32_t count_parts(std::size_t nodes, const std::vector<std::array<std::int32_t, n>>& cells) {
  Sets sets(nodes);
  for (const auto& cell : cells)
    for (std::size_t k = 1; k < n; ++k) sets.join(cell[0], cell[k]);
  std::vector<bool> seen(nodes, false);
  std::int32_t parts = 0;
  for (const auto& cell : cells) {
    const auto root = static_cast<std::size_t>(sets.root(cell[0]));
    parts += !seen[root];
    seen[root] = true;
  }
  return parts;
}
template std::int32_t count_parts(std::size_t, const std::vector<std::array<std::int32_t, 3>>&);
template std::int32_t count_parts(std::size_t, const std::vector<std::array<std::int32_t, 4>>&);

std::string weld_note(std::size_t nodes_before, std::size_t nodes_after, std::int64_t dropped, const std::string& cells,
                      std::int32_t parts) {
  const auto welded = static_cast<std::int64_t>(nodes_before - nodes_after);
  if (welded == 0 && parts == 1) return {};
  std::string text = counted(static_cast<std::int64_t>(nodes_before), "node");
  text += welded > 0 ? ", of which " + std::to_string(welded) + (welded == 1 ? " was" : " were") +
                           " welded to another one at the same place (weld: 0 keeps them apart)"
                     : ", none welded";
  if (dropped > 0) text += "; " + counted(dropped, cells) + " without extent left out";
  return text + "; " + counted(parts, "part") + (parts == 1 ? "" : ", which share no node");
}

}  // namespace unibody
