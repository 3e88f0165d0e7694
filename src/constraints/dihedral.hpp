// The angle between two triangles that share an edge: resistance to bending.
#pragma once

#include <cmath>

#include "constraints/constraint_type.hpp"

namespace unibody {

struct Dihedral {
  static constexpr std::string_view name = "dihedral";
  static constexpr std::size_t stencil = 4, rows = 1;
  static constexpr std::array<std::string_view, 2> parameter_names{"rest angle (rad)",
                                                                   "length that makes the angle a distance (m)"};

  // Bodies 0 and 1 are the ends of the edge, 2 and 3 the corners opposite: triangles (0, 1, 2) and (1, 0, 3). The angle is 0
  // where the triangles are flat, positive where they fold away from their normals, in (-pi, pi]. c = L (angle - rest).
  // Gradients after Bridson, Marino and Fedkiw (2003): along the normals, over the heights above the edge.
  static void evaluate(const std::array<Vec4d, 2>& parameters, const std::array<Vec3x4, 4>& x, Rows<4, 1>& rows) {
    const Vec3x4 edge = x[1] - x[0];
    const Vec3x4 n1 = cross(edge, x[2] - x[0]), n2 = cross(x[3] - x[0], edge);
    const Vec4d zero = broadcast(0), one = broadcast(1);
    const Vec4d squared1 = dot(n1, n1), squared2 = dot(n2, n2), edge2 = dot(edge, edge);
    const Vec4d length = sqrt(edge2);
    const Mask4 proper = (squared1 > zero) & (squared2 > zero) & (edge2 > zero);  // a collapsed triangle has no angle
    const auto inverse = [&](Vec4d v) { return select(proper, one / select(proper, v, one), zero); };
    const Vec4d sine = dot(cross(n1, n2), edge) * inverse(length), cosine = dot(n1, n2);
    Vec4d angle = zero;
    for (std::size_t l = 0; l < lanes; ++l) angle[l] = std::atan2(sine[l], cosine[l]);

    const Vec4d L = select(proper, parameters[1], zero);
    Vec4d turned = angle - parameters[0];  // the short way round
    const Vec4d full = broadcast(2 * M_PI), half = broadcast(M_PI);
    turned = select(turned > half, turned - full, select(turned < -half, turned + full, turned));
    rows.value[0] = L * turned;
    const Vec3x4 up1 = n1 * (L * length * inverse(squared1)), up2 = n2 * (L * length * inverse(squared2));
    const Vec4d along2 = dot(x[2] - x[0], edge) * inverse(edge2), along3 = dot(x[3] - x[0], edge) * inverse(edge2);
    rows.gradient[0][2] = {-up1.x, -up1.y, -up1.z};
    rows.gradient[0][3] = {-up2.x, -up2.y, -up2.z};
    rows.gradient[0][0] = up1 * (one - along2) + up2 * (one - along3);
    rows.gradient[0][1] = up1 * along2 + up2 * along3;
  }
};

}  // namespace unibody
