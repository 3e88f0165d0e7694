// A triangle of cloth that resists stretch and shear in its plane: St. Venant-Kirchhoff, plane stress.
#pragma once

#include <array>
#include <cmath>

#include "constraints/constraint_type.hpp"

namespace unibody {

struct Membrane {
  static constexpr std::string_view name = "membrane";
  static constexpr std::size_t stencil = 3, rows = 3;
  // X = Dm^-1 of the rest triangle laid into its plane with edge 1 along the first axis: upper triangular.
  static constexpr std::array<std::string_view, 4> parameter_names{"X11 (1/m)", "X12 (1/m)", "X22 (1/m)",
                                                                   "length that makes a strain a distance (m)"};

  // F = [x1 - x0, x2 - x0] X, Green's strain eps = (F^T F - 1) / 2. Rows: L (eps11 + eps22) / sqrt 2, L (eps11 - eps22) / sqrt 2,
  // L sqrt 2 eps12: the eigenvectors of the isotropic law, so that the energy is a sum of squares.
  static void evaluate(const std::array<Vec4d, 4>& p, const std::array<Vec3x4, 3>& x, Rows<3, 3>& rows) {
    const Vec3x4 d1 = x[1] - x[0], d2 = x[2] - x[0];
    const Vec3x4 f1 = d1 * p[0], f2 = d1 * p[1] + d2 * p[2];
    const Vec4d half = broadcast(0.5), one = broadcast(1), root = broadcast(std::sqrt(0.5));
    const Vec4d e11 = half * (dot(f1, f1) - one), e22 = half * (dot(f2, f2) - one), e12 = half * dot(f1, f2);
    const Vec4d s = p[3] * root;
    rows.value = {s * (e11 + e22), s * (e11 - e22), broadcast(2) * s * e12};
    // d eps11 = f1.df1, d eps22 = f2.df2, d eps12 = (f1.df2 + f2.df1) / 2, df1 = X11 dd1, df2 = X12 dd1 + X22 dd2.
    const Vec3x4 g11 = f1 * (s * p[0]), g22 = f2 * (s * p[1]), h22 = f2 * (s * p[2]);
    const Vec3x4 g12 = f1 * (s * p[1]) + f2 * (s * p[0]), h12 = f1 * (s * p[2]);
    const Vec3x4 none{broadcast(0), broadcast(0), broadcast(0)};
    set(rows, 0, g11 + g22, h22);
    set(rows, 1, g11 - g22, none - h22);
    set(rows, 2, g12, h12);
  }

  // Compliance (m/N) of the three rows for a rest triangle of this area (m^2) and thickness (m): the energy of unit strain along
  // an eigenvector is V0/2 times E/(1 - nu) or E/(1 + nu).
  static std::array<double, 3> compliance(double youngs_modulus, double poissons_ratio, double area, double thickness,
                                          double length) {
    const double per_volume = length * length / (youngs_modulus * area * thickness);
    return {(1 - poissons_ratio) * per_volume, (1 + poissons_ratio) * per_volume, (1 + poissons_ratio) * per_volume};
  }

  // Parameters of the rest triangle with these corners; the length is sqrt(2 area).
  static std::array<double, 4> at_rest(const Vec3& a, const Vec3& b, const Vec3& c) {
    const Vec3 d1 = b - a, d2 = c - a;
    const double u = d1.norm(), v = d2.dot(d1) / u, w = d1.cross(d2).norm() / u;  // Dm = [u v; 0 w]
    return {1 / u, -v / (u * w), 1 / w, std::sqrt(u * w)};
  }

 private:
  static void set(Rows<3, 3>& rows, std::size_t k, const Vec3x4& of1, const Vec3x4& of2) {
    const Vec3x4 both = of1 + of2;
    rows.gradient[k] = {Vec3x4{-both.x, -both.y, -both.z}, of1, of2};
  }
};

}  // namespace unibody
