// Welding: nodes of a mesh at one place become one. Where a file gives a node once for each patch of a texture, or with the noise
// of single precision, what is one sheet for a person would fall apart at the seams.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "core/types.hpp"

namespace unibody {

inline constexpr double usual_weld = 1e-6;  // of the longest edge of the box around the nodes

// The longest edge (m) of the box around the nodes.
double extent_of(const std::vector<Vec3>& nodes);

// Welds nodes, and returns the number that each has afterwards. In the order of their numbers, nodes stay unless one that stays
// is within `distance` (m) of them: then they become the first such. All stay where `distance` is 0. Linear in the number of
// nodes.
std::vector<std::int32_t> weld(std::vector<Vec3>& nodes, double distance);

// Renumbers the cells, and drops those of which two corners have become one; returns how many.
template <std::size_t n>
std::int64_t renumber(std::vector<std::array<std::int32_t, n>>& cells, const std::vector<std::int32_t>& number) {
  std::size_t kept = 0;
  for (auto cell : cells) {
    bool is_whole = true;
    for (std::size_t k = 0; k < n; ++k) {
      const std::int32_t before = cell[k];
      cell[k] = number[static_cast<std::size_t>(before)];
    }
    for (std::size_t k = 0; k < n; ++k)
      for (std::size_t j = 0; j < k; ++j) is_whole &= cell[j] != cell[k];
    if (is_whole) cells[kept++] = cell;
  }
  const std::size_t dropped = cells.size() - kept;
  cells.resize(kept);
  return static_cast<std::int64_t>(dropped);
}

// How many parts, which share no node, the cells make of those of the nodes that they have.
template <std::size_t n>
std::int32_t count_parts(std::size_t nodes, const std::vector<std::array<std::int32_t, n>>& cells);

// What a person should know: how many nodes were welded, cells dropped, and how many parts there are. Empty where nothing was
// welded and there is one part.
std::string weld_note(std::size_t nodes_before, std::size_t nodes_after, std::int64_t dropped, const std::string& cells,
                      std::int32_t parts);

}  // namespace unibody
