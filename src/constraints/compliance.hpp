// Contacts that give way: by a spring and a damper (Cundall & Strack, Geotechnique 29, 1979, 47), or by Hertz' law.
//
// At an overlap delta a point of contact pushes by F(delta) + c v, v the speed at which the two sides come closer, and never
// pulls. A step of length h makes of that a row whose multiplier solves lambda = max(0, h F(delta_0) - (h c + theta h^2 F') u),
// with delta_0 the overlap at the step's start and u the normal velocity at its end; F' is dF/d delta. Where the step resolves
// the contact theta is all but 0, so that the elastic force, taken at the start, together with positions that follow the
// velocities at the end, keeps the energy (symplectic Euler). Where it does not, theta is 1: implicit Euler, which is stable and
// takes speed.
#pragma once

#include "world/material_pairs.hpp"
#include "world/shapes.hpp"

namespace unibody {

struct BodyProperties;

struct ContactLaw {
  double stiffness = 0;      // N/m: F = stiffness delta
  double modulus = 0;        // Pa, E* of the pair: F = 4/3 E* sqrt(R) delta^(3/2), where the radius is not 0
  double damping = 0;        // N s/m
  double damping_ratio = 0;  // of 2 sqrt(m F'), with m the mass that the two bodies have for each other at the point
  double radius = 0;         // m, R of the two bodies (reduced_radius())

  bool complies() const { return stiffness > 0 || (modulus > 0 && radius > 0); }
  double force(double overlap) const;   // N
  double slope(double overlap) const;   // N/m, F'
  double energy(double overlap) const;  // J, the integral of F
};

ContactLaw contact_law(const MaterialPairs& pairs, const BodyProperties& a, const BodyProperties& b);

// The row's residual is u + bias + softness lambda. With the row's own 1/m it is the step above.
struct SoftRow {
  double softness;  // 1/kg
  double bias;      // m/s
};

// gap: m, at the start of the step, negative where the two overlap; mobility: 1/kg, one over the mass that they have for each
// other at the point; step: s.
SoftRow soft_row(const ContactLaw& law, double gap, double mobility, double step);

// s, how long two bodies that meet without other forces touch each other, by the stiffness alone. Of Hertz' law for an impact
// that makes them overlap by a thousandth of R.
double contact_time(const ContactLaw& law, double mobility);

}  // namespace unibody
