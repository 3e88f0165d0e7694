#include "partition/bisection.hpp"

#include <algorithm>
#include <limits>
#include <numeric>

namespace unibody {

namespace {

class Bisection {
 public:
  Bisection(std::span<const std::array<std::int32_t, 3>> cells, std::span<const float> weights)
      : cells_(cells), weights_(weights), order_(cells.size()), part_(cells.size()) {
    std::iota(order_.begin(), order_.end(), std::size_t{0});
  }

  std::vector<int> cut(int parts) && {
    cut({order_.data(), order_.size()}, 0, parts);
    return std::move(part_);
  }

 private:
  // Divides `these` cells among the parts first, first + 1, ..., first + parts - 1.
  void cut(std::span<std::size_t> these, int first, int parts) {
    if (parts == 1 || these.empty()) {
      for (const std::size_t i : these) part_[i] = first;
      return;
    }
    const std::size_t axis = longest_side(these);
    std::sort(these.begin(), these.end(), [&](std::size_t a, std::size_t b) {
      return cells_[a][axis] != cells_[b][axis] ? cells_[a][axis] < cells_[b][axis] : a < b;
    });
    const int below = parts / 2;
    const std::size_t at = where(these, static_cast<double>(below) / parts);
    cut(these.subspan(0, at), first, below);
    cut(these.subspan(at), first + below, parts - below);
  }

  std::size_t longest_side(std::span<const std::size_t> these) const {
    std::array<std::int64_t, 3> low, high;
    low.fill(std::numeric_limits<std::int64_t>::max()), high.fill(std::numeric_limits<std::int64_t>::min());
    for (const std::size_t i : these)
      for (std::size_t k = 0; k < 3; ++k)
        low[k] = std::min<std::int64_t>(low[k], cells_[i][k]), high[k] = std::max<std::int64_t>(high[k], cells_[i][k]);
    std::size_t longest = 0;
    for (std::size_t k = 1; k < 3; ++k)
      if (high[k] - low[k] > high[longest] - low[longest]) longest = k;
    return longest;
  }

  // How many of the sorted cells weigh that share of all of them, to the nearest.
  std::size_t where(std::span<const std::size_t> these, double share) const {
    double whole = 0, sum = 0;
    for (const std::size_t i : these) whole += weights_[i];
    for (std::size_t k = 0; k < these.size(); ++k) {
      const double with = sum + weights_[these[k]];
      if (with > share * whole) return with - share * whole < share * whole - sum ? k + 1 : k;
      sum = with;
    }
    return these.size();
  }

  std::span<const std::array<std::int32_t, 3>> cells_;
  std::span<const float> weights_;
  std::vector<std::size_t> order_;
  std::vector<int> part_;
};

}  // namespace

std::vector<int> bisect(std::span<const std::array<std::int32_t, 3>> cells, std::span<const float> weights, int parts) {
  return Bisection(cells, weights).cut(parts);
}

}  // namespace unibody
