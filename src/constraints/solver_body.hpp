// A body as the solvers see it: velocity and inverse mass, laid out for the inner loop.
//
// A contact is linear in the velocities inside a step (its gap is frozen, or linearised anew before each iteration), so the
// solvers move velocities only: u -> u + W D^T lambda. One cache line a body holds all that a sphere's contact needs.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "core/simd.hpp"
#include "core/types.hpp"

namespace unibody {

// Velocity of a body and its inverse mass. A static body has inverse mass and inertia 0: corrections leave it unchanged.
struct alignas(64) SolverBody {
  double v[3];             // m/s
  double inverse_mass;     // 1/kg
  double w[3];             // rad/s, world frame
  double inverse_inertia;  // 1/(kg m^2), where it is the same about every axis; else see InverseInertia
};

// World-frame inverse inertia of a body for which it is no multiple of the identity.
struct InverseInertia {
  double xx, yy, zz, yz, xz, xy;
};

// World-frame inverse inertia of a slot, 1/(kg m^2).
inline Mat3 inverse_inertia_of(std::span<const SolverBody> bodies, std::span<const InverseInertia> inertia,
                               std::span<const std::uint8_t> isotropic, std::size_t slot) {
  if (isotropic[slot]) return bodies[slot].inverse_inertia * Mat3::Identity();
  const InverseInertia& w = inertia[slot];
  Mat3 all;
  all << w.xx, w.xy, w.xz, w.xy, w.yy, w.yz, w.xz, w.yz, w.zz;
  return all;
}

// Sum of the constraint impulses on a body in one sweep: N s and N m s, about its centre.
struct alignas(64) Wrench {
  Vec4d force, torque;  // x, y, z, 0
};

}  // namespace unibody
