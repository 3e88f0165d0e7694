#include "coarse/conjugate_gradients.hpp"

#include <algorithm>
#include <cmath>

#include "core/exact_sum.hpp"
#include "core/largest.hpp"

namespace unibody {

namespace {

class Solve {
 public:
  Solve(const LinearSystem& system, std::size_t slots)
      : s_(system),
        z_(slots, Vec3::Zero()),
        d_(slots, Vec3::Zero()),
        p_(slots, Vec3::Zero()),
        q_(slots, Vec3::Zero()),
        t_(slots, Vec3::Zero()) {}

  LinearReport run(std::span<Vec3> r, std::span<Vec3> x, double share, int most) {
    LinearReport report;
    largest_ = 0;
    for (std::size_t k = 0; k < s_.matrix.rows(); ++k) largest_ = std::max(largest_, at(r, k).lpNorm<Eigen::Infinity>());
    largest_ = largest_of_ranks(s_.comm, largest_);
    std::ranges::fill(x, Vec3::Zero());
    if (largest_ == 0) return report.left = 0, report;
    if (s_.coarse != nullptr) {  // the coarse part of the solution first: what follows keeps to the rest
      s_.coarse->correct(r, largest_, x);
      s_.matrix.multiply(x, q_);
      for (std::size_t k = 0; k < s_.matrix.rows(); ++k) at(r, k) -= at(q_, k);
    }
    precondition(r);
    double rz = dot(r, z_), first = rz;
    std::ranges::copy(z_, p_.begin());
    for (int i = 0; i < most && rz > 0 && std::isfinite(rz); ++i) {
      s_.matrix.multiply(p_, q_);
      const double alpha = rz / dot(p_, q_);
      for (std::size_t j = 0; j < x.size(); ++j) x[j] += alpha * p_[j];
      for (std::size_t k = 0; k < s_.matrix.rows(); ++k) at(r, k) -= alpha * at(q_, k);
      precondition(r);
      const double next = dot(r, z_), beta = next / rz;
      rz = next, ++report.iterations;
      report.left = std::sqrt(std::max(0.0, rz / first));
      if (report.left <= share) break;
      for (std::size_t j = 0; j < p_.size(); ++j) p_[j] = z_[j] + beta * p_[j];
    }
    return report;
  }

 private:
  template <class Vector>
  auto at(Vector&& v, std::size_t row) const -> decltype((v[row])) {
    return v[static_cast<std::size_t>(s_.matrix.slot_of(row))];
  }
  double dot(std::span<const Vec3> a, std::span<const Vec3> b) const {
    ExactSum sum;
    for (std::size_t k = 0; k < s_.matrix.rows(); ++k) sum += at(a, k).dot(at(b, k));
    return all_sums(s_.comm, std::span(&sum, 1))[0];
  }

  // z_ = B r. Chebyshev's iteration aims at the eigenvalues that the coarse level leaves, the upper part of them.
  void precondition(std::span<const Vec3> r) {
    constexpr double ratio = 6;
    const double most = s_.largest_eigenvalue, least = most / ratio;
    const double middle = 0.5 * (most + least), half = 0.5 * (most - least), sigma = middle / half;
    const double rho = 1 / sigma, next = 1 / (2 * sigma - rho);
    const BlockMatrix& H = s_.matrix;
    for (std::size_t k = 0; k < H.rows(); ++k) at(d_, k) = s_.inverse[k] * at(r, k) / middle;
    s_.refresh(d_);
    H.multiply(d_, t_);
    for (std::size_t k = 0; k < H.rows(); ++k) {
      const Vec3 step = next * rho * at(d_, k) + 2 * next / half * (s_.inverse[k] * (at(r, k) - at(t_, k)));
      at(z_, k) = at(d_, k) + step;
    }
    s_.refresh(z_);
    if (s_.coarse == nullptr) return;
    H.multiply(z_, t_);
    for (std::size_t k = 0; k < H.rows(); ++k) at(t_, k) = at(r, k) - at(t_, k);
    s_.coarse->correct(t_, 64 * largest_, z_);
  }

  const LinearSystem& s_;
  std::vector<Vec3> z_, d_, p_, q_, t_;  // by slot
  double largest_ = 0;                   // of the first residual's entries, over all ranks
};

}  // namespace

LinearReport conjugate_gradients(const LinearSystem& system, std::span<Vec3> b, std::span<Vec3> x, double share, int most) {
  return Solve(system, x.size()).run(b, x, share, most);
}

}  // namespace unibody
