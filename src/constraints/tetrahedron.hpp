// A tetrahedron of a soft solid: St. Venant-Kirchhoff (paper, section 3.3 and Algorithm 3, with the rest volume).
#pragma once

#include <Eigen/LU>
#include <array>
#include <cmath>

#include "constraints/constraint_type.hpp"

namespace unibody {

struct Tetrahedron {
  static constexpr std::string_view name = "tetrahedron";
  static constexpr std::size_t stencil = 4, rows = 6;
  static constexpr bool starts_cold = true;  // see constraint_type.hpp
  static constexpr bool fills_space = true;
  // X = Dm^-1, Dm the rest edges from node 0, by rows: F = [x1 - x0, x2 - x0, x3 - x0] X.
  static constexpr std::array<std::string_view, 10> parameter_names{
      "X11 (1/m)", "X12 (1/m)", "X13 (1/m)", "X21 (1/m)", "X22 (1/m)",
      "X23 (1/m)", "X31 (1/m)", "X32 (1/m)", "X33 (1/m)", "length that makes a strain a distance (m)"};

  // Green's strain eps = (F^T F - 1) / 2. Rows, times L: the volumetric tr eps / sqrt 3; the deviatoric (eps11 - eps22) / sqrt 2,
  // (eps11 + eps22 - 2 eps33) / sqrt 6; the shears sqrt 2 eps23, sqrt 2 eps13, sqrt 2 eps12. They are orthonormal eigenvectors of
  // the isotropic law, so that the energy is a sum of squares.
  static void evaluate(const std::array<Vec4d, 10>& p, const std::array<Vec3x4, 4>& x, Rows<4, 6>& rows) {
    const std::array<Vec3x4, 3> d{x[1] - x[0], x[2] - x[0], x[3] - x[0]};
    std::array<Vec3x4, 3> f;  // columns of F
    for (std::size_t j = 0; j < 3; ++j) f[j] = d[0] * p[j] + d[1] * p[3 + j] + d[2] * p[6 + j];
    const Vec4d half = broadcast(0.5), one = broadcast(1), s = p[9];
    const Vec4d e11 = half * (dot(f[0], f[0]) - one), e22 = half * (dot(f[1], f[1]) - one), e33 = half * (dot(f[2], f[2]) - one);
    const Vec4d volumetric = s * broadcast(std::sqrt(1.0 / 3)), across = s * broadcast(std::sqrt(0.5));
    const Vec4d along = s * broadcast(std::sqrt(1.0 / 6)), two = broadcast(2);
    rows.value = {volumetric * (e11 + e22 + e33), across * (e11 - e22),     along * (e11 + e22 - two * e33),
                  across * dot(f[1], f[2]),       across * dot(f[0], f[2]), across * dot(f[0], f[1])};
    // Node 1 + i moves column j of F by p[3 i + j]: d eps_jk = (f_j . df_k + f_k . df_j) / 2.
    for (std::size_t i = 0; i < 3; ++i) {
      const Vec4d X1 = p[3 * i], X2 = p[3 * i + 1], X3 = p[3 * i + 2];
      const Vec3x4 g1 = f[0] * X1, g2 = f[1] * X2, g3 = f[2] * X3, sum = g1 + g2;
      rows.gradient[0][1 + i] = (sum + g3) * volumetric;
      rows.gradient[1][1 + i] = (g1 - g2) * across;
      rows.gradient[2][1 + i] = (sum - g3 * two) * along;
      rows.gradient[3][1 + i] = (f[1] * X3 + f[2] * X2) * across;
      rows.gradient[4][1 + i] = (f[0] * X3 + f[2] * X1) * across;
      rows.gradient[5][1 + i] = (f[0] * X2 + f[1] * X1) * across;
    }
    const Vec3x4 none{broadcast(0), broadcast(0), broadcast(0)};
    for (std::size_t k = 0; k < 6; ++k)
      rows.gradient[k][0] = none - (rows.gradient[k][1] + rows.gradient[k][2] + rows.gradient[k][3]);
  }

  // The second derivatives of row k by the places of nodes a and b, which are these numbers times the identity: f_j . f_l has
  // b_ja b_lb + b_la b_jb, b_j what each node adds to f_j.
  static std::array<std::array<std::array<double, 4>, 4>, 6> second_derivatives(const std::array<double, 10>& p) {
    Eigen::Matrix<double, 3, 4> b;
    for (int j = 0; j < 3; ++j)
      for (int i = 0; i < 3; ++i) b(j, 1 + i) = p[static_cast<std::size_t>(3 * i + j)];
    b.col(0) = -b.rightCols<3>().rowwise().sum();
    const auto strain = [&](int j, int l) -> Eigen::Matrix4d {  // 2 eps_jl
      return b.row(j).transpose() * b.row(l) + b.row(l).transpose() * b.row(j);
    };
    const Eigen::Matrix4d e11 = 0.5 * strain(0, 0), e22 = 0.5 * strain(1, 1), e33 = 0.5 * strain(2, 2);
    const double volumetric = p[9] * std::sqrt(1.0 / 3), across = p[9] * std::sqrt(0.5), along = p[9] * std::sqrt(1.0 / 6);
    const std::array<Eigen::Matrix4d, 6> rows{volumetric * (e11 + e22 + e33), across * (e11 - e22),
                                              along * (e11 + e22 - 2 * e33),  across * strain(1, 2),
                                              across * strain(0, 2),          across * strain(0, 1)};
    std::array<std::array<std::array<double, 4>, 4>, 6> result;
    for (std::size_t k = 0; k < 6; ++k)
      for (int i = 0; i < 16; ++i)
        result[k][static_cast<std::size_t>(i / 4)][static_cast<std::size_t>(i % 4)] = rows[k](i / 4, i % 4);
    return result;
  }

  // Compliance (m/N) of the rows for a rest volume (m^3): the energy of a strain of unit norm along an eigenvector is V0/2 times
  // E/(1 - 2 nu) (volumetric) or E/(1 + nu).
  static std::array<double, 6> compliance(double youngs_modulus, double poissons_ratio, double volume, double length) {
    const double per_volume = length * length / (youngs_modulus * volume);
    const double deviatoric = (1 + poissons_ratio) * per_volume;
    return {(1 - 2 * poissons_ratio) * per_volume, deviatoric, deviatoric, deviatoric, deviatoric, deviatoric};
  }

  // Parameters of the rest tetrahedron with these corners, positively oriented; the length is the cube root of 6 volumes.
  static std::array<double, 10> at_rest(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
    Eigen::Matrix3d edges;
    edges << b - a, c - a, d - a;
    const Eigen::Matrix3d X = edges.inverse();
    std::array<double, 10> parameters;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) parameters[static_cast<std::size_t>(3 * i + j)] = X(i, j);
    parameters[9] = std::cbrt(edges.determinant());
    return parameters;
  }
};

}  // namespace unibody
