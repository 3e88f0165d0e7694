// Broad phase: all pairs of axis-aligned bounds that overlap and of which at least one is a home body, in O(n log n) with a
// small factor.
//
// A hierarchical grid of rows. A body belongs to the level whose cells are just larger than its bounds, and there, by its
// centre's y and z, to a row along x in which bodies are sorted by x. So it meets its own level by sweeping its row and the 4
// neighbouring rows after it, in memory order, and each coarser level in at most 9 rows, by bisection. Rows are found by
// hashing, a few look-ups a row, so that empty space costs nothing. The price is a factor (number of occupied levels) for
// bodies of very different sizes: 14 levels for a ratio of 10^4. Levels of a few bodies are tested one by one instead.
#pragma once

#include "collide/contacts.hpp"

namespace unibody {

struct Bounds {
  Vec3 lower, upper;
};

// Two bodies by index, first < second.
struct IndexPair {
  std::int32_t first, second;
};

enum class Role : std::uint8_t { home, other, absent };  // absent: not in the grid (planes)

class BroadPhase {
 public:
  // Appends the pairs to `pairs`, in no particular order. Bounds that are not finite overlap nothing.
  void find(const std::vector<Bounds>& bounds, const std::vector<Role>& roles, std::vector<IndexPair>& pairs);

  // Sorts pairs of indices below `count` by (first, second): by counting on the first, then within each few.
  void sort(std::vector<IndexPair>& pairs, std::size_t count);

 private:
  struct Entry {
    Vec3 lower, upper;
    std::int32_t index;
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

  void choose_levels(const std::vector<Bounds>& bounds, const std::vector<Role>& roles);
  void fill(const std::vector<Bounds>& bounds, const std::vector<Role>& roles);
  std::int32_t find_row(std::int64_t y, std::int64_t z, std::int32_t level) const;
  std::int32_t find_or_add_row(std::int64_t y, std::int64_t z, std::int32_t level);
  void within_row(const Row& row, std::vector<IndexPair>& pairs) const;
  void between_rows(const Row& a, const Row& b, std::vector<IndexPair>& pairs) const;
  void with_coarser(const Row& row, std::vector<IndexPair>& pairs) const;

  std::vector<Level> levels_;           // the occupied ones, ascending in size
  std::vector<std::int32_t> level_of_;  // by body; -1 when not in the grid
  std::vector<std::int32_t> row_of_;    // by body
  std::vector<Row> rows_;
  std::vector<Place> places_;                   // by row, then x
  std::vector<Entry> entries_;                  // likewise
  std::vector<std::vector<std::int32_t>> few_;  // by level: its entries, if they are few
  std::vector<std::int32_t> table_;             // open addressing: row number or -1
  std::size_t mask_ = 0;
  std::vector<std::uint32_t> starts_;  // of sort()
  std::vector<IndexPair> scratch_;
};

}  // namespace unibody
