// Mass properties of a solid inside a closed surface of triangles, exact up to rounding: sums over the tetrahedra between the
// triangles and one point (the divergence theorem).
#pragma once

#include <array>
#include <span>

#include "core/types.hpp"

namespace unibody {

struct SolidMoments {
  double volume = 0;             // m^3; negative where the triangles face inwards
  Vec3 centre = Vec3::Zero();    // m, of mass
  Vec3 inertia = Vec3::Zero();   // m^2, principal moments about the centre, per mass
  Quat axes = Quat::Identity();  // principal axes -> those of the nodes: of all choices the least turn
};

// The moments that follow from the second moments of the mass about its centre, per mass (m^2).
SolidMoments moments_of(double volume, const Vec3& centre, const Mat3& second);

SolidMoments solid_moments(std::span<const Vec3> nodes, std::span<const std::array<std::int32_t, 3>> triangles);

}  // namespace unibody
