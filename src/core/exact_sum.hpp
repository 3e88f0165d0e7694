// Sums of doubles without rounding: the same bits in any order and on any number of ranks.
#pragma once

#include <mpi.h>

#include <array>
#include <bit>
#include <cstdint>
#include <span>
#include <vector>

namespace unibody {

// A fixed-point number wide enough for every double: limb k counts units of 2^(32 k - 1074). Limbs are signed and hold 31 bits
// more than they need, so that carries are settled only once in 2^30 additions. Overflow is impossible below 2^63 addends.
class ExactSum {
 public:
  static constexpr int limb_count = 69;  // 2098 bits from the smallest subnormal to the largest double, and 110 for carries

  void add(double x) {
    const auto bits = std::bit_cast<std::uint64_t>(x);
    const auto exponent = static_cast<int>(bits >> 52 & 0x7ff);
    if (exponent == 0x7ff) return add_special(bits);
    if (pending_ == pending_limit) settle();
    ++pending_;
    const std::uint64_t fraction = bits & ((std::uint64_t{1} << 52) - 1);
    const std::uint64_t mantissa = exponent == 0 ? fraction : fraction | std::uint64_t{1} << 52;
    const int place = exponent == 0 ? 0 : exponent - 1;
    const auto limb = static_cast<std::size_t>(place >> 5);
    const int shift = place & 31;
    const std::uint64_t low = (mantissa & 0xffffffff) << shift;  // below 2^63
    const std::uint64_t high = (mantissa >> 32) << shift;        // below 2^52
    const auto l0 = static_cast<std::int64_t>(low & 0xffffffff);
    const auto l1 = static_cast<std::int64_t>((low >> 32) + (high & 0xffffffff));
    const auto l2 = static_cast<std::int64_t>(high >> 32);
    const std::int64_t sign = (bits >> 63) != 0 ? -1 : 1;
    limbs_[limb] += sign * l0, limbs_[limb + 1] += sign * l1, limbs_[limb + 2] += sign * l2;
  }
  ExactSum& operator+=(double x) { return add(x), *this; }
  ExactSum& operator+=(const ExactSum& other);

  // The exact sum rounded once, to nearest even. NaN if a NaN or both infinities were added, else the infinity that was.
  double value() const;
  bool finite() const { return specials_[0] == 0 && specials_[1] == 0 && specials_[2] == 0; }

 private:
  friend std::vector<double> all_sums(MPI_Comm comm, std::span<const ExactSum> sums);
  static constexpr int pending_limit = 1 << 30;
  static constexpr int packed_count = limb_count + 3;

  void add_special(std::uint64_t bits);
  void settle();  // carries: limbs in [0, 2^32), the last one signed

  std::array<std::int64_t, limb_count> limbs_{};
  std::array<std::int64_t, 3> specials_{};  // how many NaN, +Inf, -Inf
  int pending_ = 0;                         // additions since the last settling
};

// Several sums over all ranks in one message; the same on each rank. Collective; as many sums on every rank.
std::vector<double> all_sums(MPI_Comm comm, std::span<const ExactSum> sums);

}  // namespace unibody
