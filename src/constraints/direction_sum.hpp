// By how much the constraints on a body, together, may move it further than each alone: what the Jacobi solvers divide a step by.
//
// For each body b the rows D_i of its constraints are to satisfy sum_ij D_i w D_j^T <= c_b diag(D_i w D_i^T). That holds with
// c_b the largest eigenvalue of S_b = sum_i P_i, P_i the projector on the directions in which constraint i pushes the body's
// centre: v_i in the range of P_i gives |sum v_i|^2 <= c_b sum |v_i|^2. P_i <= 1, so c_b is at most the number of constraints,
// the usual factor; links of cloth, which pull each way, need half of it.
//
// That is of directions that stay, and links turn within a step. So at least three quarters of the number are taken: no mode is
// then further beyond the bound than momentum bears (momentum.hpp), whichever way links turn. Nor do large cloths bear much less:
// far from converged they swing up from step to step, as the impulses of the first iterations keep their directions. With 0.6 one
// of 100 x 100 nodes did so at 100 iterations, with 2/3 not.
#pragma once

#include <array>
#include <span>

#include "core/simd.hpp"

namespace unibody {

inline constexpr double least_sharing = 0.75;  // of the number of constraints

// S_b of one body.
struct DirectionSum {
  Vec4d squares{}, products{};  // xx, yy, zz, number of constraints; xy, yz, zx, 0

  // Adds so many constraints that may push along any direction.
  void add_any(double count) { squares += broadcast(count); }
};

// What four gradients d add to the sums of their bodies: d d^T over_square, where that is 1 / |d|^2.
struct Directions {
  Directions() = default;
  Directions(const Vec3x4& d, Vec4d over_square) {
    const Vec3x4 n = d * over_square;
    squares = {d.x * n.x, d.y * n.y, d.z * n.z, broadcast(1)};
    products = {d.x * n.y, d.y * n.z, d.z * n.x, broadcast(0)};
    transpose(squares[0], squares[1], squares[2], squares[3]);
    transpose(products[0], products[1], products[2], products[3]);
  }
  void add_to(DirectionSum& sum, std::size_t lane) const { sum.squares += squares[lane], sum.products += products[lane]; }

  std::array<Vec4d, lanes> squares, products;  // of each lane
};

// Bounds the largest eigenvalues of four sums from above, by at most 3^(1/16) = 1.07 times: |S^8|^(1/8) in Frobenius' norm. It is
// exact where all directions are the same. Where `least` bounds |S| already, as of most nodes of a cloth, it is that.
inline Vec4d largest_eigenvalues(std::span<const DirectionSum, lanes> sums, Vec4d least = broadcast(0)) {
  Vec4d xx = sums[0].squares, yy = sums[1].squares, zz = sums[2].squares, fourth = sums[3].squares;
  Vec4d xy = sums[0].products, yz = sums[1].products, zx = sums[2].products, last = sums[3].products;
  transpose(xx, yy, zz, fourth), transpose(xy, yz, zx, last);
  const auto norm = [&] {  // squared
    const Vec4d off = xy * xy + yz * yz + zx * zx;
    return xx * xx + yy * yy + zz * zz + off + off;
  };
  const Mask4 is_more = norm() > least * least;
  if (!any(is_more)) return least;
  for (int k = 0; k < 3; ++k) {  // S becomes S^2
    const Vec4d a = xy * xy, b = yz * yz, c = zx * zx;
    const Vec4d new_xy = xy * (xx + yy) + yz * zx, new_yz = yz * (yy + zz) + zx * xy, new_zx = zx * (zz + xx) + xy * yz;
    xx = xx * xx + a + c, yy = yy * yy + a + b, zz = zz * zz + b + c;
    xy = new_xy, yz = new_yz, zx = new_zx;
  }
  return select(is_more, max(sqrt(sqrt(sqrt(sqrt(norm())))), least), least);
}

}  // namespace unibody
