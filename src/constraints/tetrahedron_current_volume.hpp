// A tetrahedron as the paper writes it (equations (39)-(44)): the strains of Tetrahedron weighted with the root of its current
// volume, not of that at rest. The energy J/2 eps C eps (J = V/V0) is not St. Venant-Kirchhoff's: a bar without Poisson effect
// takes the nominal stress E/8 (l^2 - 1) (5 l^2 - 1) at the stretch l, greatest in compression at l = .775 (St.
// Venant-Kirchhoff .577), none at .447, tensile below. It is there for comparison with the paper.
#pragma once

#include "constraints/tetrahedron.hpp"

namespace unibody {

struct TetrahedronCurrentVolume {
  static constexpr std::string_view name = "tetrahedron_current_volume";
  static constexpr std::size_t stencil = Tetrahedron::stencil, rows = Tetrahedron::rows;
  static constexpr bool starts_cold = true;
  static constexpr bool fills_space = true;
  static constexpr auto parameter_names = Tetrahedron::parameter_names;
  static constexpr double least_share = 0.01;  // of the rest volume: the weight falls no further, as a negative J has no root

  // c_k = sqrt(J) c_k of Tetrahedron, with V0 = L^3 / 6.
  static void evaluate(const std::array<Vec4d, 10>& p, const std::array<Vec3x4, 4>& x, Rows<4, 6>& rows) {
    Tetrahedron::evaluate(p, x, rows);
    const Vec3x4 a = x[1] - x[0], b = x[2] - x[0], c = x[3] - x[0];
    const Vec4d per_volume = broadcast(1) / (p[9] * p[9] * p[9]);
    const Vec3x4 da = cross(b, c) * per_volume, db = cross(c, a) * per_volume, dc = cross(a, b) * per_volume;
    const Vec4d share = dot(a, da);
    const Vec4d root = sqrt(max(share, broadcast(least_share)));
    const Vec4d slope = select(share > broadcast(least_share), broadcast(0.5) / root, broadcast(0));  // of the root by J
    const Vec3x4 sum = da + db + dc, none{broadcast(0), broadcast(0), broadcast(0)};
    const std::array<Vec3x4, 4> volume{none - sum, da, db, dc};
    for (std::size_t k = 0; k < 6; ++k) {
      for (std::size_t e = 0; e < 4; ++e) rows.gradient[k][e] = rows.gradient[k][e] * root + volume[e] * (slope * rows.value[k]);
      rows.value[k] = rows.value[k] * root;
    }
  }
};

}  // namespace unibody
