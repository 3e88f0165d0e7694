// Disjoint sets of numbers: which nodes of a mesh hang together.
#pragma once

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <vector>

namespace unibody {

// Sets joined step by step; the root of each is its smallest member.
class Sets {
 public:
  explicit Sets(std::size_t count) : parent_(count) { std::iota(parent_.begin(), parent_.end(), 0); }
  std::int32_t root(std::int32_t i) {
    while (at(i) != i) i = at(i) = at(at(i));
    return i;
  }
  void join(std::int32_t i, std::int32_t j) {
    const auto [low, high] = std::minmax({root(i), root(j)});
    at(high) = low;
  }

 private:
  std::vector<std::int32_t> parent_;
  std::int32_t& at(std::int32_t i) { return parent_[static_cast<std::size_t>(i)]; }
};

}  // namespace unibody
