#include "coarse/block_matrix.hpp"

#include <algorithm>

namespace unibody {

void BlockMatrix::set_pattern(std::vector<std::pair<Slot, Slot>> pairs, std::span<const Id> ids) {
  // Slots of homes, guests and statics each ascend by id, but not one after the other: columns are ordered by id.
  const auto id = [&](Slot s) { return ids[static_cast<std::size_t>(s)]; };
  std::ranges::sort(
      pairs, [&](const auto& a, const auto& b) { return a.first != b.first ? a.first < b.first : id(a.second) < id(b.second); });
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  slot_of_row_.clear(), first_.clear(), diagonal_.clear(), column_.clear();
  row_of_slot_.assign(ids.size(), -1);
  for (const auto& [row, column] : pairs) {
    if (slot_of_row_.empty() || slot_of_row_.back() != row) {
      row_of_slot_[static_cast<std::size_t>(row)] = static_cast<std::int32_t>(slot_of_row_.size());
      slot_of_row_.push_back(row), first_.push_back(column_.size()), diagonal_.push_back(0);
    }
    if (row == column) diagonal_.back() = column_.size();
    column_.push_back(column);
  }
  first_.push_back(column_.size());
  blocks_.assign(column_.size(), Block{});
}

void BlockMatrix::set_zero() { std::ranges::fill(blocks_, Block{}); }

std::ptrdiff_t BlockMatrix::place_of(Slot row, Slot column) const {
  const std::int32_t r = row_of_slot_[static_cast<std::size_t>(row)];
  if (r < 0) return -1;
  for (std::size_t k = first_[static_cast<std::size_t>(r)]; k < first_[static_cast<std::size_t>(r) + 1]; ++k)
    if (column_[k] == column) return static_cast<std::ptrdiff_t>(k);
  return -1;
}

void BlockMatrix::multiply(std::span<const Vec3> x, std::span<Vec3> y) const {
  for (std::size_t r = 0; r < rows(); ++r) {
    Vec4d sum = broadcast(0);
    for (std::size_t k = first_[r]; k < first_[r + 1]; ++k) sum += times(blocks_[k], x[static_cast<std::size_t>(column_[k])]);
    y[static_cast<std::size_t>(slot_of_row_[r])] = to_vec3(sum);
  }
}

std::size_t BlockMatrix::bytes() const {
  return blocks_.capacity() * sizeof(Block) + column_.capacity() * sizeof(Slot) +
         rows() * (sizeof(Slot) + 2 * sizeof(std::size_t)) + row_of_slot_.capacity() * sizeof(std::int32_t);
}

}  // namespace unibody
