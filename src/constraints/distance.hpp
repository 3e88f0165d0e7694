// Two bodies' centres at a distance: a link of cloth or thread, a spring where it has compliance 1/k (k in N/m).
#pragma once

#include "constraints/constraint_type.hpp"

namespace unibody {

struct Distance {
  static constexpr std::string_view name = "distance";
  static constexpr std::size_t stencil = 2, rows = 1;
  static constexpr bool unit_gradients = true;
  static constexpr std::array<std::string_view, 1> parameter_names{"rest length (m)"};

  // c = |x0 - x1| - l.
  [[gnu::always_inline]] static inline void evaluate(const std::array<Vec4d, 1>& parameters, const std::array<Vec3x4, 2>& x,
                                                     Rows<2, 1>& rows) {
    const Vec3x4 between = x[0] - x[1];
    const Vec4d zero = broadcast(0), squared = dot(between, between);
    const Vec4d length = sqrt(squared);
    const Mask4 apart = squared > zero;
    const Vec4d inverse = select(apart, length * (broadcast(1) / squared), zero);
    const Vec3x4 n{between.x * inverse, between.y * inverse,
                   select(apart, between.z * inverse, broadcast(1))};  // two that coincide part along z
    rows.value[0] = length - parameters[0];
    rows.gradient[0][0] = n;
    rows.gradient[0][1] = {-n.x, -n.y, -n.z};
  }
};

// The same between second neighbours: resists bending, and is no stretch.
struct BendingLink : Distance {
  static constexpr std::string_view name = "bending_link";
};

}  // namespace unibody
