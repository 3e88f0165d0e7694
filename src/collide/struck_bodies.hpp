// Bodies that others set moving within a step, and how fast what is near them may be set moving in turn (step/struck.hpp).
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "core/types.hpp"

namespace unibody {

struct Struck {
  Vec3 centre;       // m, at the start of the step
  Vec3 way;          // m, that its centre goes in the step
  double reach;      // m, from the start: what the body may touch in the step
  double speed;      // m/s, of its fastest point
  double half_size;  // m, half of its smallest size
  Id id;
  std::int32_t group;
  std::int32_t number = 0;  // free for whoever makes the list
};

class StruckBodies {
 public:
  void add(const std::vector<Struck>& more);
  void clear() { bodies_.clear(), cells_.clear(); }
  bool empty() const { return bodies_.empty(); }

  // m/s, of the fastest whose reach touches a ball; 0: none does. Whatever the order in which they were added.
  double speed_at(const Vec3& centre, double radius) const {
    double fastest = 0;
    for_each_near(centre, radius, [&](const Struck& s) { fastest = std::max(fastest, s.speed); });
    return fastest;
  }

  // Calls f(struck) for all whose reach touches a ball.
  template <class F>
  void for_each_near(const Vec3& centre, double radius, F&& f) const {
    const auto look = [&](const Struck& s) {
      if ((s.centre - centre).norm() < s.reach + radius) f(s);
    };
    if (empty()) return;
    const Vec3 around = Vec3::Constant(radius + edge_);
    const Cell low = cell_of(centre - around), high = cell_of(centre + around);
    const double columns = static_cast<double>(high[0] - low[0] + 1) * static_cast<double>(high[1] - low[1] + 1);
    if (columns > static_cast<double>(bodies_.size())) {
      std::ranges::for_each(bodies_, look);
      return;
    }
    for (std::int64_t x = low[0]; x <= high[0]; ++x)
      for (std::int64_t y = low[1]; y <= high[1]; ++y) {
        auto cell = std::ranges::lower_bound(cells_, Cell{x, y, low[2]});
        for (; cell != cells_.end() && *cell <= Cell{x, y, high[2]}; ++cell)
          look(bodies_[static_cast<std::size_t>(cell - cells_.begin())]);
      }
  }

 private:
  using Cell = std::array<std::int64_t, 3>;
  Cell cell_of(const Vec3& place) const;

  std::vector<Struck> bodies_;  // by cell
  std::vector<Cell> cells_;     // of each, ascending
  double edge_ = 0;             // m, of a cell: the largest reach
};

}  // namespace unibody
