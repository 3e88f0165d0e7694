#include "coarse/coarse_space.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/checked.hpp"
#include "core/largest.hpp"
#include "partition/messages.hpp"

namespace unibody {

namespace {

// Rounds to multiples of a power of two, `unit`, what is smaller than 2^51 of it.
class Rounding {
 public:
  // So that so many addends as large as `largest` have an exact sum.
  Rounding(double largest, int log_of_addends) {
    const int exponent = largest > 0 ? std::ilogb(largest) + 1 : 0;
    magic_ = std::ldexp(1.5, 52 + exponent + log_of_addends - 51);
  }
  double operator()(double x) const { return (x + magic_) - magic_; }

 private:
  double magic_;
};

constexpr int log_of_members = 10, log_of_blocks = 14;  // of what an aggregate sums, with room to spare

Mat3 cross_matrix(const Vec3& r) {
  Mat3 m;
  m << 0, -r.z(), r.y(), r.z(), 0, -r.x(), -r.y(), r.x(), 0;
  return m;
}

}  // namespace

void CoarseSpace::set(MPI_Comm comm, const BlockMatrix& matrix, std::vector<std::int32_t> aggregate, std::int32_t count,
                      std::size_t homes, std::span<const Id> ids) {
  comm_ = comm, count_ = count, homes_ = homes, aggregate_ = std::move(aggregate);
  const auto n = static_cast<std::size_t>(count);
  const auto of = [&](Slot s) { return aggregate_[static_cast<std::size_t>(s)]; };
  std::vector<Id> lowest(n, std::numeric_limits<Id>::max());
  first_member_.assign(n, -1);
  for (std::size_t i = 0; i < homes; ++i)
    if (const std::int32_t a = aggregate_[i]; a >= 0 && first_member_[static_cast<std::size_t>(a)] < 0)
      first_member_[static_cast<std::size_t>(a)] = static_cast<Slot>(i), lowest[static_cast<std::size_t>(a)] = ids[i];
  const std::vector<Id> own = lowest;
  check_mpi(MPI_Allreduce(MPI_IN_PLACE, lowest.data(), count, MPI_INT64_T, MPI_MIN, comm));
  for (std::size_t a = 0; a < n; ++a)
    if (own[a] != lowest[a]) first_member_[a] = -1;

  std::vector<std::int32_t> here;
  for (std::size_t r = 0; r < matrix.rows(); ++r)
    for (std::size_t k = matrix.begin_of(r); k < matrix.end_of(r); ++k) {
      const std::int32_t a = of(matrix.slot_of(r)), b = of(matrix.column_of(k));
      if (a >= b && b >= 0 && (here.size() < 2 || here[here.size() - 2] != a || here.back() != b))
        here.insert(here.end(), {a, b});
    }
  const auto make_pairs = [](std::span<const std::int32_t> numbers) {
    std::vector<std::pair<std::int32_t, std::int32_t>> pairs;
    for (std::size_t i = 0; i < numbers.size(); i += 2) pairs.emplace_back(numbers[i], numbers[i + 1]);
    std::ranges::sort(pairs);
    pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
    return pairs;
  };
  const auto unique = make_pairs(here);
  here.clear();
  for (const auto& [a, b] : unique) here.insert(here.end(), {a, b});
  pairs_ = make_pairs(all_of_ranks<std::int32_t>(comm, here));
  first_pair_.assign(n + 1, pairs_.size());
  for (std::size_t p = pairs_.size(); p-- > 0;) first_pair_[static_cast<std::size_t>(pairs_[p].first)] = p;
  for (std::size_t a = n; a-- > 0;) first_pair_[a] = std::min(first_pair_[a], first_pair_[a + 1]);
  sums_.assign(36 * pairs_.size(), 0);
  factor_ = std::make_shared<Factor>();
  is_analysed_ = false;
}

std::size_t CoarseSpace::pair_of(std::int32_t row, std::int32_t column) const {
  const auto begin = pairs_.begin() + static_cast<std::ptrdiff_t>(first_pair_[static_cast<std::size_t>(row)]);
  const auto end = pairs_.begin() + static_cast<std::ptrdiff_t>(first_pair_[static_cast<std::size_t>(row) + 1]);
  return static_cast<std::size_t>(std::lower_bound(begin, end, std::pair(row, column)) - pairs_.begin());
}

void CoarseSpace::find_centres(std::span<const Vec3> places) {
  centre_.assign(static_cast<std::size_t>(count_), Vec3::Constant(-std::numeric_limits<double>::infinity()));
  for (std::size_t a = 0; a < centre_.size(); ++a)
    if (first_member_[a] >= 0) centre_[a] = places[static_cast<std::size_t>(first_member_[a])];
  make_largest(comm_, {centre_.data()->data(), 3 * centre_.size()});
}

void CoarseSpace::find_arms(std::span<const Vec3> places, std::span<const std::uint8_t> moves) {
  moves_.assign(moves.begin(), moves.end());
  arm_.assign(aggregate_.size(), Vec3::Zero());
  scale_ = 0;
  for (std::size_t i = 0; i < aggregate_.size(); ++i) {
    if (aggregate_[i] < 0) moves_[i] = 0;
    if (moves_[i] == 0) continue;
    arm_[i] = places[i] - centre_[static_cast<std::size_t>(aggregate_[i])];
    if (i < homes_) scale_ = std::max(scale_, arm_[i].lpNorm<Eigen::Infinity>());
  }
  scale_ = largest_of_ranks(comm_, scale_);
  if (!(scale_ > 0)) scale_ = 1;
  for (Vec3& arm : arm_) arm /= scale_;
}

void CoarseSpace::add_row(const BlockMatrix& matrix, std::size_t row, double largest, std::span<const std::uint8_t> moves) {
  const Rounding round(largest, log_of_blocks);
  const auto i = static_cast<std::size_t>(matrix.slot_of(row));
  if (moves[i] == 0) return;
  const Mat3 left = cross_matrix(arm_[i]);
  for (std::size_t k = matrix.begin_of(row); k < matrix.end_of(row); ++k) {
    const auto j = static_cast<std::size_t>(matrix.column_of(k));
    if (moves[j] == 0 || aggregate_[j] > aggregate_[i]) continue;
    Mat3 H;
    for (int c = 0; c < 3; ++c) H.col(c) = to_vec3(matrix.block(k)[static_cast<std::size_t>(c)]);
    const Mat3 right = -H * cross_matrix(arm_[j]);
    Block B;
    B.topLeftCorner<3, 3>() = H, B.topRightCorner<3, 3>() = right;
    B.bottomLeftCorner<3, 3>() = left * H, B.bottomRightCorner<3, 3>() = left * right;
    double* sum = &sums_[36 * pair_of(aggregate_[i], aggregate_[j])];
    for (int e = 0; e < 36; ++e) sum[e] += round(B.data()[e]);
  }
}

void CoarseSpace::factorise(const BlockMatrix& matrix, std::span<const Vec3> places, std::span<const std::uint8_t> moves) {
  find_centres(places);
  find_arms(places, moves);
  double largest = 0;
  for (std::size_t r = 0; r < matrix.rows(); ++r)
    for (std::size_t k = matrix.begin_of(r); k < matrix.end_of(r); ++k)
      for (const Vec4d& column : matrix.block(k)) largest = std::max(largest, horizontal_max(abs(column)));
  largest = largest_of_ranks(comm_, largest);
  std::ranges::fill(sums_, 0.0);
  for (std::size_t r = 0; r < matrix.rows(); ++r) add_row(matrix, r, 4 * largest, moves_);
  check_mpi(MPI_Allreduce(MPI_IN_PLACE, sums_.data(), static_cast<int>(sums_.size()), MPI_DOUBLE, MPI_SUM, comm_));

  // What no motion of the bodies answers to (a turn of a straight thread about itself) has nothing on the diagonal but noise.
  constexpr double least = 1e-9;
  std::vector<Eigen::Triplet<double>> entries;
  entries.reserve(sums_.size());
  for (std::size_t p = 0; p < pairs_.size(); ++p)
    for (int c = 0; c < 6; ++c)
      for (int r = 0; r < 6; ++r) {
        const int row = 6 * pairs_[p].first + r, column = 6 * pairs_[p].second + c;
        double value = sums_[36 * p + static_cast<std::size_t>(6 * c + r)];
        if (row < column) continue;
        if (row == column) value = value > least * largest ? value * (1 + least) : largest;
        entries.emplace_back(row, column, value);
      }
  Eigen::SparseMatrix<double> A(6 * count_, 6 * count_);
  A.setFromTriplets(entries.begin(), entries.end());
  if (!is_analysed_) factor_->analyzePattern(A);
  is_analysed_ = true;
  factor_->factorize(A);
}

void CoarseSpace::correct(std::span<const Vec3> r, double largest, std::span<Vec3> z) const {
  const Rounding round(largest, log_of_members);
  right_.setZero(6 * count_);
  for (std::size_t i = 0; i < homes_; ++i) {
    if (moves_[i] == 0) continue;
    const Vec3 turn = arm_[i].cross(r[i]);
    double* to = &right_[6 * aggregate_[i]];
    for (int k = 0; k < 3; ++k) to[k] += round(r[i][k]), to[3 + k] += round(turn[k]);
  }
  check_mpi(MPI_Allreduce(MPI_IN_PLACE, right_.data(), 6 * count_, MPI_DOUBLE, MPI_SUM, comm_));
  const Eigen::VectorXd motion = factor_->solve(right_);
  for (std::size_t i = 0; i < moves_.size(); ++i) {
    if (moves_[i] == 0) continue;
    const auto at = motion.segment<6>(6 * aggregate_[i]);
    z[i] += at.head<3>() + at.tail<3>().cross(arm_[i]);
  }
}

std::size_t CoarseSpace::bytes() const {
  return sums_.capacity() * 3 * sizeof(double) + arm_.capacity() * sizeof(Vec3) + aggregate_.capacity() * sizeof(std::int32_t);
}

}  // namespace unibody
