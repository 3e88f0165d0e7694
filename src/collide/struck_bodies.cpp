#include "collide/struck_bodies.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace unibody {

StruckBodies::Cell StruckBodies::cell_of(const Vec3& place) const {
  constexpr double most = 1e15;
  Cell cell{};
  for (int k = 0; k < 3; ++k)
    cell[static_cast<std::size_t>(k)] = static_cast<std::int64_t>(std::floor(std::clamp(place[k] / edge_, -most, most)));
  return cell;
}

void StruckBodies::add(const std::vector<Struck>& more) {
  std::vector<Struck> all(bodies_);
  all.insert(all.end(), more.begin(), more.end());
  for (const Struck& s : more) edge_ = std::max(edge_, s.reach);
  std::vector<Cell> cells;
  for (const Struck& s : all) cells.push_back(cell_of(s.centre));
  std::vector<std::size_t> order(all.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::sort(order, {}, [&](std::size_t i) { return std::pair(cells[i], i); });
  bodies_.clear(), cells_.clear();
  for (const std::size_t i : order) bodies_.push_back(all[i]), cells_.push_back(cells[i]);
}

}  // namespace unibody
