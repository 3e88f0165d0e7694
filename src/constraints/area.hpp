// A triangle that keeps its area, whatever its shape.
#pragma once

#include "constraints/constraint_type.hpp"

namespace unibody {

struct Area {
  static constexpr std::string_view name = "area";
  static constexpr std::size_t stencil = 3, rows = 1;
  static constexpr std::array<std::string_view, 2> parameter_names{"rest area (m^2)", "length that makes an area a distance (m)"};

  // c = (A - A0) / L.
  [[gnu::always_inline]] static inline void evaluate(const std::array<Vec4d, 2>& parameters, const std::array<Vec3x4, 3>& x,
                                                     Rows<3, 1>& rows) {
    const Vec3x4 d1 = x[1] - x[0], d2 = x[2] - x[0], twice = cross(d1, d2);
    const Vec4d zero = broadcast(0), squared = dot(twice, twice), norm = sqrt(squared);
    const Vec4d over_length = broadcast(1) / parameters[1];
    rows.value[0] = (broadcast(0.5) * norm - parameters[0]) * over_length;
    const Vec3x4 n = twice * (select(squared > zero, broadcast(0.5) / norm, zero) * over_length);
    rows.gradient[0][1] = cross(d2, n);
    rows.gradient[0][2] = cross(n, d1);
    const Vec3x4 both = rows.gradient[0][1] + rows.gradient[0][2];
    rows.gradient[0][0] = {-both.x, -both.y, -both.z};
  }
};

}  // namespace unibody
