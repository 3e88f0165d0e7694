#include "partition/hilbert.hpp"

#include <algorithm>
#include <numeric>

#include "core/checked.hpp"

namespace unibody {

CurvePlace hilbert_place(std::array<std::uint32_t, 3> cell, int bits) {
  auto& x = cell;
  for (std::uint32_t bit = std::uint32_t{1} << (bits - 1); bit > 1; bit >>= 1) {
    const std::uint32_t below = bit - 1;
    for (std::uint32_t& coordinate : x)
      if ((coordinate & bit) != 0) {
        x[0] ^= below;
      } else {
        const std::uint32_t swapped = (x[0] ^ coordinate) & below;
        x[0] ^= swapped, coordinate ^= swapped;
      }
  }
  x[1] ^= x[0], x[2] ^= x[1];
  std::uint32_t turned = 0;
  for (std::uint32_t bit = std::uint32_t{1} << (bits - 1); bit > 1; bit >>= 1)
    if ((x[2] & bit) != 0) turned ^= bit - 1;
  for (std::uint32_t& coordinate : x) coordinate ^= turned;
  CurvePlace place = 0;
  for (int bit = bits - 1; bit >= 0; --bit)
    for (const std::uint32_t coordinate : x) place = place << 1 | (coordinate >> bit & 1);
  return place;
}

namespace {

// Finds every cut at once, some bits of its place at a time, by the weights of the stretches of the curve where it may lie.
class Cutting {
 public:
  Cutting(MPI_Comm comm, std::span<const WeighedPlace> here, std::span<const int> shares, int whole)
      : comm_(comm), here_(here), sum_(here.size() + 1, 0), cuts_(shares.size()) {
    for (std::size_t i = 0; i < here.size(); ++i) sum_[i + 1] = sum_[i] + here[i].weight;
    std::int64_t total = sum_.back();
    check_mpi(MPI_Allreduce(MPI_IN_PLACE, &total, 1, MPI_INT64_T, MPI_SUM, comm));
    for (std::size_t k = 0; k < shares.size(); ++k)
      cuts_[k].target = static_cast<std::int64_t>(static_cast<CurvePlace>(total) * static_cast<CurvePlace>(shares[k]) /
                                                  static_cast<CurvePlace>(whole));
  }

  std::vector<CurvePlace> find(int bits) {
    for (int left = 3 * bits; left > 0;) {
      const int step = std::min(left, 4);
      left -= step;
      refine(left, std::size_t{1} << step);
    }
    std::vector<CurvePlace> places;
    for (const Cut& cut : cuts_) {
      const bool after = cut.target - cut.before > cut.before + cut.here - cut.target;
      places.push_back(cut.place + (after ? 1 : 0));
    }
    return places;
  }

 private:
  struct Cut {
    std::int64_t target = 0;
    CurvePlace place = 0;               // the stretch where it lies begins here
    std::int64_t before = 0, here = 0;  // weight before the stretch, and of it
  };

  std::int64_t weight_before(CurvePlace place) const {
    const auto at = std::ranges::lower_bound(here_, place, {}, &WeighedPlace::place);
    return sum_[static_cast<std::size_t>(at - here_.begin())];
  }

  // Each cut's stretch becomes one of its `parts`, of 2^bits places each.
  void refine(int bits, std::size_t parts) {
    std::vector<std::int64_t> weight(cuts_.size() * parts);
    for (std::size_t k = 0; k < cuts_.size(); ++k)
      for (std::size_t p = 0; p < parts; ++p) {
        const CurvePlace begin = cuts_[k].place + (static_cast<CurvePlace>(p) << bits);
        weight[k * parts + p] = weight_before(begin + (static_cast<CurvePlace>(1) << bits)) - weight_before(begin);
      }
    check_mpi(MPI_Allreduce(MPI_IN_PLACE, weight.data(), mpi_count(weight.size()), MPI_INT64_T, MPI_SUM, comm_));
    for (std::size_t k = 0; k < cuts_.size(); ++k) {
      Cut& cut = cuts_[k];
      std::size_t p = 0;
      for (; p + 1 < parts && cut.before + weight[k * parts + p] < cut.target; ++p) cut.before += weight[k * parts + p];
      cut.here = weight[k * parts + p];
      cut.place += static_cast<CurvePlace>(p) << bits;
    }
  }

  MPI_Comm comm_;
  std::span<const WeighedPlace> here_;
  std::vector<std::int64_t> sum_;  // of the weights before each place
  std::vector<Cut> cuts_;
};

}  // namespace

std::vector<CurvePlace> cuts_along_curve(MPI_Comm comm, std::span<const WeighedPlace> here, std::span<const int> shares, int whole,
                                         int bits) {
  return Cutting(comm, here, shares, whole).find(bits);
}

}  // namespace unibody
