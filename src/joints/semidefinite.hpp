// The small systems of a joint's rows, of which some may say the same.
#pragma once

#include <array>
#include <cstddef>

namespace unibody {

inline constexpr double least_pivot = 1e-10;  // of a row's diagonal: below, others determine it already

// Solves P d = b for symmetric positive semidefinite P (lower triangle) by L D L^T. A row whose pivot is round-off gets d = 0.
template <std::size_t n>
std::array<double, n> solve_semidefinite(std::array<std::array<double, n>, n> P, std::array<double, n> b) {
  std::array<double, n> inverse;
  for (std::size_t j = 0; j < n; ++j) {
    double pivot = P[j][j];
    for (std::size_t k = 0; k < j; ++k) pivot -= P[j][k] * P[j][k] * inverse[k];
    inverse[j] = pivot > least_pivot * P[j][j] ? 1 / pivot : 0;
    for (std::size_t i = j + 1; i < n; ++i)
      for (std::size_t k = 0; k < j; ++k) P[i][j] -= P[i][k] * P[j][k] * inverse[k];
    for (std::size_t k = 0; k < j; ++k) b[j] -= P[j][k] * inverse[k] * b[k];
  }
  for (std::size_t i = n; i-- > 0;) {
    b[i] *= inverse[i];
    for (std::size_t k = i + 1; k < n && inverse[i] > 0; ++k) b[i] -= P[k][i] * inverse[i] * b[k];
  }
  return b;
}

}  // namespace unibody
