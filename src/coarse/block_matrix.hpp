// A sparse matrix of blocks of 3 x 3, whose rows are those of this rank's home bodies. A row is summed in the order of the
// constraints and multiplied in the order of its columns' ids, whoever holds it.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "core/simd.hpp"
#include "core/types.hpp"

namespace unibody {

class BlockMatrix {
 public:
  using Block = std::array<Vec4d, 3>;  // its three columns; the fourth component is 0

  // Slots (row, column), in any order and as often as may be. `ids` are the slots' bodies.
  void set_pattern(std::vector<std::pair<Slot, Slot>> pairs, std::span<const Id> ids);
  void set_zero();

  std::size_t rows() const { return slot_of_row_.size(); }
  Slot slot_of(std::size_t row) const { return slot_of_row_[row]; }
  std::size_t begin_of(std::size_t row) const { return first_[row]; }
  std::size_t end_of(std::size_t row) const { return first_[row + 1]; }
  std::size_t diagonal_of(std::size_t row) const { return diagonal_[row]; }
  Slot column_of(std::size_t place) const { return column_[place]; }
  const Block& block(std::size_t place) const { return blocks_[place]; }
  Block& block(std::size_t place) { return blocks_[place]; }
  std::ptrdiff_t place_of(Slot row, Slot column) const;  // -1: none

  // y = H x, vectors by slot; x of guests must be up to date. Other entries of y stay.
  void multiply(std::span<const Vec3> x, std::span<Vec3> y) const;

  std::size_t bytes() const;

 private:
  std::vector<Slot> slot_of_row_;          // ascending
  std::vector<std::int32_t> row_of_slot_;  // -1: none
  std::vector<std::size_t> first_, diagonal_;
  std::vector<Slot> column_;
  std::vector<Block> blocks_;
};

inline Vec3 to_vec3(Vec4d a) { return {a[0], a[1], a[2]}; }

inline Vec4d times(const BlockMatrix::Block& block, const Vec3& x) {
  return block[0] * broadcast(x[0]) + block[1] * broadcast(x[1]) + block[2] * broadcast(x[2]);
}

}  // namespace unibody
