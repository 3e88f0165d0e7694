// What a step's solve works on: velocities, inverse masses and the batches of constraints, laid out for the inner loop.
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

// What a pass reads of the step: positions at its start with, as fourth component, c_b / m_b: the inverse mass times the factor
// by which its constraints together may move it further than each alone (Jacobi; see direction_sum.hpp), and the step.
struct StepStart {
  std::span<const Vec4d> places;             // x_l, y_l, z_l (m), c_b / m_b (1/kg)
  double step;                               // s
  std::span<const Vec4d> moved_places = {};  // the same at x_l + h v of the last sweep's velocities; for Jacobi sweeps alone
  double stabilisation = -1;                 // of the velocity level, whose rows are linear about x_l; else negative

  bool is_linear() const { return stabilisation >= 0; }
};

// Where the next Jacobi sweep starts: new + momentum (new - old multiplier) + overshoot (new - where this sweep started).
struct Extrapolation {
  double momentum = 0, overshoot = 0;
};

// What one sweep tells the solver. Maxima and fixed-point sums: the same whatever the order or the number of ranks.
struct SweepSums {
  std::int64_t gradient = 0;  // sum r . (new - old multiplier), the gradient restart test, in units of `unit`
  std::int64_t progress = 0;  // sum P |new - y|^2, the residual restart test, in units of `unit`
  double largest = 0;         // largest single term of the two sums (J): sets the unit of the sweeps that follow
  double change = 0;          // largest P |new - y| (m): the sweep's own residual, for the stop test
  double unit = 1;            // J
};

// Rounds a term to a whole number of units, clamped so that 2^22 terms cannot overflow.
inline std::int64_t whole_units(double term, double per_unit) {
  const double scaled = std::min(std::max(term * per_unit, -1.0e12), 1.0e12);
  return static_cast<std::int64_t>(std::llrint(scaled));
}

// Four terms at once, with the same bits: adding 1.5 * 2^52 leaves the rounded number in the low half of the word.
inline Mask4 whole_units(Vec4d terms, double per_unit) {
  constexpr double shift = 6755399441055744.0;
  const Vec4d scaled = min(max(terms * broadcast(per_unit), broadcast(-1.0e12)), broadcast(1.0e12));
  return reinterpret_cast<Mask4>(scaled + broadcast(shift)) - reinterpret_cast<Mask4>(broadcast(shift));
}

}  // namespace unibody
