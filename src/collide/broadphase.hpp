// Broad phase: all pairs of boxes (axis-aligned bounds) that overlap and of which at least one is a home body, in O(n).
//
// A hierarchical grid: each body sits, by its centre, in one cell of the level whose cells are just larger than its bounds,
// so a body meets all of its own level in the 27 cells around it, and each coarser level in at most 27 cells more.
// Cells are found by hashing, so that empty space costs nothing. The price is a factor (number of occupied levels) for
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
  struct Cell {
    std::int64_t x, y, z;
    std::int32_t level, first, count;
  };
  struct Level {
    double size, inverse;  // m, 1/m, of a cell
    std::int32_t population;
    std::int32_t offset;  // into by_level_, for levels of a few bodies
  };

  void choose_levels(const std::vector<Bounds>& bounds, const std::vector<Role>& roles);
  void fill(const std::vector<Bounds>& bounds, const std::vector<Role>& roles);
  std::int32_t find_cell(std::int64_t x, std::int64_t y, std::int64_t z, std::int32_t level) const;
  std::int32_t find_or_add_cell(std::int64_t x, std::int64_t y, std::int64_t z, std::int32_t level);
  void within_cell(const Cell& cell, std::vector<IndexPair>& pairs) const;
  void between_cells(const Cell& a, const Cell& b, std::vector<IndexPair>& pairs) const;
  void with_coarser(const Cell& cell, std::vector<IndexPair>& pairs) const;

  std::vector<Level> levels_;           // the occupied ones, ascending in size
  std::vector<std::int32_t> level_of_;  // by body; -1 when not in the grid
  std::vector<std::int32_t> cell_of_;   // by body
  std::vector<Cell> cells_;
  std::vector<Entry> entries_;          // by cell
  std::vector<std::int32_t> by_level_;  // entries of the levels of a few bodies
  std::vector<std::int32_t> table_;     // open addressing: cell number or -1
  std::size_t mask_ = 0;
  std::vector<std::uint32_t> starts_;  // of sort()
  std::vector<IndexPair> scratch_;
};

}  // namespace unibody
