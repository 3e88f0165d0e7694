// What a kind of constraint that follows the contacts remembers of them: a few numbers for each pair of bodies that touch.
// A batch whose history is a PairHistory names these numbers in its constant history_columns. Migration, checkpoints and changes
// of the bodies take the history along.
#pragma once

#include <array>
#include <vector>

#include "core/types.hpp"

namespace unibody {

template <std::size_t width>
struct PairRecord {
  std::array<Id, 2> key;  // the pair, ascending
  std::array<double, width> value;
};

// Ascending keys, each once, of pairs with a home body here.
template <std::size_t width>
using PairHistory = std::vector<PairRecord<width>>;

template <class History>
inline constexpr std::size_t pair_width = 0;  // of what is no PairHistory
template <std::size_t width>
inline constexpr std::size_t pair_width<PairHistory<width>> = width;

}  // namespace unibody
