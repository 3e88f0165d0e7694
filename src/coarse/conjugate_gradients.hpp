// Conjugate gradients for H x = b on vectors of home bodies, with two levels: two steps of Chebyshev's iteration on the diagonal
// blocks, then a correction by the coarse space. The same bits on any number of ranks: each body's row is its home's, sums over
// bodies are exact.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "coarse/block_matrix.hpp"
#include "coarse/coarse_space.hpp"

namespace unibody {

struct LinearSystem {
  const BlockMatrix& matrix;
  std::span<const Mat3> inverse;  // of the diagonal block of each row
  const CoarseSpace* coarse;      // null: one level
  double largest_eigenvalue;      // a bound of those of the diagonal blocks' inverse times the matrix
  MPI_Comm comm;
  std::function<void(std::span<Vec3>)> refresh;  // of guests from their homes; collective
};

struct LinearReport {
  int iterations = 0;
  double left = 1;  // of the preconditioned residual's norm, a share of that at the start
};

// Solves H x = b, vectors by slot. Only the entries of home bodies are read of b, which is overwritten; x is set for guests too.
// The iterations stop when the preconditioned residual has fallen to that share of what it was. Collective.
LinearReport conjugate_gradients(const LinearSystem& system, std::span<Vec3> b, std::span<Vec3> x, double share, int most);

}  // namespace unibody
