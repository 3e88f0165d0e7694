// Recursive coordinate bisection: cuts weighted cells of space into parts by planes across the longest side of what is left.
// Always balanced to within a cell, whatever the weights; blind to what ties cells together. It stands in where METIS cannot be
// used.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace unibody {

// The part of each cell, in [0, parts). weights: >= 0, of each cell. A pure function.
std::vector<int> bisect(std::span<const std::array<std::int32_t, 3>> cells, std::span<const float> weights, int parts);

}  // namespace unibody
