// How the mass of a compound lies among its parts.
#pragma once

#include <span>

#include "world/compound.hpp"

namespace unibody {

// Where parts overlap, `twice` counts the mass of each of them, and `once` counts that of the first part in the list alone.
enum class Overlap : std::uint8_t { twice, once };

struct CompoundMass {
  double volume = 0;  // m^3
  double mass = 0;    // kg
  Vec3 centre = Vec3::Zero();
  Mat3 second = Mat3::Zero();  // m^2, of the mass about the centre, per mass
};

// Sums the mass of parts with these densities (kg/m^3) by the closed formulas of their shapes. With Overlap::once, the volume
// that a part shares with parts before it is found by 10^6 points of the box around it, to some 1e-3 of that volume, and taken
// away.
CompoundMass compound_mass(std::span<const Compound::Part> parts, std::span<const double> densities, Overlap overlap);

}  // namespace unibody
