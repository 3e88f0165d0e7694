// The small systems of a joint's rows, of which some may say the same.
#pragma once

#include <array>
#include <cstddef>

namespace unibody {

inline constexpr double least_pivot = 1e-10;  // of a row's diagonal: below, others determine it already

// P of n rows, symmetric positive semidefinite, factored as L D L^T: its lower triangle row by row, then the inverses of D. A row
// whose pivot is round-off has 0 there.
template <std::size_t n>
struct Semidefinite {
  static constexpr std::size_t size = n * (n + 1) / 2 + n;  // numbers
  static constexpr std::size_t at(std::size_t row, std::size_t column) { return row * (row + 1) / 2 + column; }
  static constexpr std::size_t inverse_at(std::size_t row) { return n * (n + 1) / 2 + row; }

  // P: in its place; the diagonal stays as it is.
  static void factor(double* P) {
    double* const inverse = P + inverse_at(0);
    for (std::size_t j = 0; j < n; ++j) {
      double pivot = P[at(j, j)];
      for (std::size_t k = 0; k < j; ++k) pivot -= P[at(j, k)] * P[at(j, k)] * inverse[k];
      inverse[j] = pivot > least_pivot * P[at(j, j)] ? 1 / pivot : 0;
      for (std::size_t i = j + 1; i < n; ++i)
        for (std::size_t k = 0; k < j; ++k) P[at(i, j)] -= P[at(i, k)] * P[at(j, k)] * inverse[k];
    }
  }

  // d of P d = b, P factored; 0 where another row determines it already.
  static std::array<double, n> solve(const double* P, std::array<double, n> b) {
    const double* const inverse = P + inverse_at(0);
    for (std::size_t j = 0; j < n; ++j)
      for (std::size_t k = 0; k < j; ++k) b[j] -= P[at(j, k)] * inverse[k] * b[k];
    for (std::size_t i = n; i-- > 0;) {
      b[i] *= inverse[i];
      for (std::size_t k = i + 1; k < n && inverse[i] > 0; ++k) b[i] -= P[at(k, i)] * inverse[i] * b[k];
    }
    return b;
  }
};

// Solves P d = b, P by its lower triangle.
template <std::size_t n>
std::array<double, n> solve_semidefinite(const std::array<std::array<double, n>, n>& P, const std::array<double, n>& b) {
  std::array<double, Semidefinite<n>::size> packed;
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = 0; j <= i; ++j) packed[Semidefinite<n>::at(i, j)] = P[i][j];
  Semidefinite<n>::factor(packed.data());
  return Semidefinite<n>::solve(packed.data(), b);
}

}  // namespace unibody
