// Broad phase: all pairs of axis-aligned bounds that overlap and of which at least one is a home body, in O(n log n) with a
// small factor.
//
// A hierarchical grid of rows. A body belongs to the level whose cells are just larger than its bounds, and there, by its
// centre's y and z, to a row along x in which bodies are sorted by x. So it meets its own level by sweeping its row and the 4
// neighbouring rows after it, in memory order, and each coarser level in at most 9 rows, by bisection. Rows are found by
// hashing, a few look-ups a row, so that empty space costs nothing. The price is a factor (number of occupied levels) for
// bodies of very different sizes: 14 levels for a ratio of 10^4. Levels of a few bodies are tested one by one instead.
#pragma once

#include <deque>
#include <memory_resource>
#include <span>
#include <vector>

#include "core/types.hpp"

namespace unibody {

struct Bounds {
  Vec3 lower, upper;
};

// Two bodies by index, first < second.
struct IndexPair {
  std::int32_t first, second;
};

using Pairs = std::pmr::deque<IndexPair>;  // a vector that grows would need room for itself twice

enum class Role : std::uint8_t { home, other, absent };  // absent: not in the grid (planes)

// Whom a body may meet: those of another group (or of none, -1) whose kind it accepts and who accept its own.
struct Filter {
  std::int32_t group = -1;
  std::uint8_t kind = 1, accepts = 1;  // bits

  bool meets(const Filter& other) const {
    return (kind & other.accepts) != 0 && (other.kind & accepts) != 0 && (group < 0 || group != other.group);
  }
};

class BroadPhase {
 public:
  explicit BroadPhase(std::pmr::memory_resource* memory = std::pmr::get_default_resource());

  // Appends the pairs to `pairs`, in no particular order; bodies are numbered from `first`. Bounds that are not finite overlap
  // nothing. Without filters all meet all.
  void find(std::span<const Bounds> bounds, std::span<const Role> roles, Pairs& pairs, std::span<const Filter> filters = {},
            std::int32_t first = 0);

  // Pairs of indices below `count`, sorted by (first, second): by counting on the first, then within each few. Valid until the
  // next.
  std::span<const IndexPair> sort(const Pairs& pairs, std::size_t count);

 private:
  struct Entry {
    Vec3 lower, upper;
    std::int32_t index;
    Filter filter;
    bool home;
  };
  struct Row {
    std::int64_t y, z;
    std::int32_t level, first, last;  // entries [first, last)
  };
  struct Level {
    double size, inverse;  // m, 1/m, of a cell
    std::int32_t population;
  };
  struct Place {
    double x;
    std::int32_t index;
  };

  void choose_levels(std::span<const Bounds> bounds, std::span<const Role> roles);
  void fill(std::span<const Bounds> bounds, std::span<const Role> roles, std::span<const Filter> filters, std::int32_t first);
  std::int32_t find_row(std::int64_t y, std::int64_t z, std::int32_t level) const;
  std::int32_t find_or_add_row(std::int64_t y, std::int64_t z, std::int32_t level);
  void within_row(const Row& row, Pairs& pairs) const;
  void between_rows(const Row& a, const Row& b, Pairs& pairs) const;
  void with_coarser(const Row& row, Pairs& pairs) const;

  std::pmr::vector<Level> levels_;           // the occupied ones, ascending in size
  std::pmr::vector<std::int32_t> level_of_;  // by body; -1 when not in the grid
  std::pmr::vector<std::int32_t> row_of_;    // by body
  std::pmr::vector<Row> rows_;
  std::pmr::vector<Place> places_;                        // by row, then x
  std::pmr::vector<Entry> entries_;                       // likewise
  std::pmr::vector<std::pmr::vector<std::int32_t>> few_;  // by level: its entries, if they are few
  std::pmr::vector<std::int32_t> table_;                  // open addressing: row number or -1
  std::size_t mask_ = 0;
  std::pmr::vector<std::uint32_t> starts_;  // of sort()
  std::pmr::vector<IndexPair> sorted_;
};

}  // namespace unibody
