// The graph of cells that METIS cuts: cells of space for loose bodies, patches of nodes for cloths, threads and solids.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "core/types.hpp"

namespace unibody {

// A patch is a cell in a layer of its own: x its number, y its group.
inline constexpr std::int32_t patch_layer = std::numeric_limits<std::int32_t>::min();

struct Cell {
  std::int32_t x, y, z;
  float weight;
  std::int32_t owner;  // rank that holds most of it now
  std::int32_t unused = 0;

  bool is_patch() const { return z == patch_layer; }
  std::array<std::int32_t, 3> place() const { return {x, y, z}; }
  std::int64_t whole_weight() const { return std::max<std::int64_t>(1, std::llround(weight)); }
};

// Cells that constraints or joints tie together.
struct CellLink {
  Cell a, b;
  float weight;
};

Cell cell_at(const Vec3& p, double edge);

// Sorted by place without repeats; weights added, the heaviest contributor owns.
std::vector<Cell> merge(std::vector<Cell> cells);

// The cell of that place in a sorted list, or null.
const Cell* find_cell(std::span<const Cell> sorted, const Cell& cell);

// The part of each cell, in [0, parts). Where METIS fails, or leaves a part with more than twice its share, the cells are cut by
// planes (bisection.hpp), which is said on stderr. cells: as merge() leaves them. owners: the parts are numbered so that each
// part p overlaps what rank first_owner + p owns as much as may be.
std::vector<int> cut_cells(const std::vector<Cell>& cells, std::span<const CellLink> links, int parts, int first_owner);

}  // namespace unibody
