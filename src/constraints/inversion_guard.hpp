// Keeps a tetrahedron from turning inside out: one unilateral row on the ratio of its volume to that at rest. St.
// Venant-Kirchhoff alone has stress-free inverted states, such as F = diag(-1, 1, 1).
#pragma once

#include <array>

#include "constraints/constraint_type.hpp"

namespace unibody {

struct InversionGuard {
  static constexpr std::string_view name = "inversion_guard";
  static constexpr std::size_t stencil = 4, rows = 1;
  static constexpr bool unilateral = true;  // c >= 0, complementary to a multiplier >= 0
  static constexpr std::array<std::string_view, 3> parameter_names{"6 V0 (m^3)", "least V / V0 (1)",
                                                                   "length that makes a ratio a distance (m)"};

  // c = L (V / V0 - least), V = (x1 - x0) . (x2 - x0) x (x3 - x0) / 6.
  static void evaluate(const std::array<Vec4d, 3>& p, const std::array<Vec3x4, 4>& x, Rows<4, 1>& rows) {
    const Vec3x4 a = x[1] - x[0], b = x[2] - x[0], c = x[3] - x[0];
    const Vec4d scale = p[2] / p[0];
    const Vec3x4 ga = cross(b, c) * scale, gb = cross(c, a) * scale, gc = cross(a, b) * scale;
    rows.value[0] = dot(a, ga) - p[1] * p[2];
    const Vec3x4 sum = ga + gb + gc;
    rows.gradient[0] = {Vec3x4{-sum.x, -sum.y, -sum.z}, ga, gb, gc};
  }
};

}  // namespace unibody
