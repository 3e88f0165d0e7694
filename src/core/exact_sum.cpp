#include "core/exact_sum.hpp"

#include <cmath>
#include <limits>

#include "core/checked.hpp"

namespace unibody {

namespace {

constexpr std::size_t limbs = ExactSum::limb_count;
using Limbs = std::array<std::int64_t, limbs>;

void carry(Limbs& a) {
  for (std::size_t k = 0; k + 1 < limbs; ++k) {
    const std::int64_t up = a[k] >> 32;  // arithmetic: rounds down, so that what stays is not negative
    a[k] -= up * (std::int64_t{1} << 32);
    a[k + 1] += up;
  }
}

// Bits [first, first + 53) of a settled non-negative number.
std::uint64_t mantissa_at(const Limbs& a, int first) {
  std::uint64_t m = 0;
  for (int k = 0; k < 53; ++k) {
    const int bit = first + k;
    const auto limb = static_cast<std::size_t>(bit >> 5);
    if (limb < limbs) m |= (static_cast<std::uint64_t>(a[limb]) >> (bit & 31) & 1) << k;
  }
  return m;
}

bool any_below(const Limbs& a, int bit) {
  const auto limb = static_cast<std::size_t>(bit >> 5);
  for (std::size_t k = 0; k < limb; ++k)
    if (a[k] != 0) return true;
  return (a[limb] & ((std::int64_t{1} << (bit & 31)) - 1)) != 0;
}

double rounded_magnitude(const Limbs& a) {
  std::size_t top = limbs;
  while (top > 0 && a[top - 1] == 0) --top;
  if (top == 0) return 0;
  const int highest =
      32 * static_cast<int>(top - 1) + static_cast<int>(std::bit_width(static_cast<std::uint64_t>(a[top - 1]))) - 1;
  if (highest <= 52) return std::ldexp(static_cast<double>(mantissa_at(a, 0)), -1074);
  const int first = highest - 52;
  std::uint64_t mantissa = mantissa_at(a, first);
  const int half_bit = first - 1;
  const bool half = (a[static_cast<std::size_t>(half_bit >> 5)] >> (half_bit & 31) & 1) != 0;
  if (half && (any_below(a, half_bit) || (mantissa & 1) != 0)) ++mantissa;
  return std::ldexp(static_cast<double>(mantissa), first - 1074);
}

}  // namespace

void ExactSum::add_special(std::uint64_t bits) {
  const bool nan = (bits & ((std::uint64_t{1} << 52) - 1)) != 0;
  ++specials_[nan ? 0 : (bits >> 63) == 0 ? 1 : 2];
}

void ExactSum::settle() {
  carry(limbs_);
  pending_ = 1;  // a settled limb is as large as one addend
}

ExactSum& ExactSum::operator+=(const ExactSum& other) {
  ExactSum settled = other;
  settled.settle();
  settle();
  for (std::size_t k = 0; k < limbs; ++k) limbs_[k] += settled.limbs_[k];
  for (std::size_t k = 0; k < 3; ++k) specials_[k] += settled.specials_[k];
  pending_ = 2;
  return *this;
}

double ExactSum::value() const {
  if (specials_[0] != 0 || (specials_[1] != 0 && specials_[2] != 0)) return std::numeric_limits<double>::quiet_NaN();
  if (specials_[1] != 0) return std::numeric_limits<double>::infinity();
  if (specials_[2] != 0) return -std::numeric_limits<double>::infinity();
  Limbs a = limbs_;
  carry(a);
  if (a[limbs - 1] >= 0) return rounded_magnitude(a);
  for (auto& limb : a) limb = -limb;
  carry(a);
  return -rounded_magnitude(a);
}

std::vector<double> all_sums(MPI_Comm comm, std::span<const ExactSum> sums) {
  constexpr auto stride = static_cast<std::size_t>(ExactSum::packed_count);
  std::vector<std::int64_t> packed;
  packed.reserve(stride * sums.size());
  for (ExactSum sum : sums) {
    sum.settle();
    packed.insert(packed.end(), sum.limbs_.begin(), sum.limbs_.end());
    packed.insert(packed.end(), sum.specials_.begin(), sum.specials_.end());
  }
  // A sum of integers: exact in any order. Settled limbs leave room for 2^31 ranks.
  check_mpi(MPI_Allreduce(MPI_IN_PLACE, packed.data(), static_cast<int>(packed.size()), MPI_INT64_T, MPI_SUM, comm));
  std::vector<double> values;
  for (std::size_t s = 0; s < sums.size(); ++s) {
    ExactSum total;
    const auto* from = packed.data() + stride * s;
    for (std::size_t k = 0; k < limbs; ++k) total.limbs_[k] = from[k];
    for (std::size_t k = 0; k < 3; ++k) total.specials_[k] = from[limbs + k];
    values.push_back(total.value());
  }
  return values;
}

}  // namespace unibody
