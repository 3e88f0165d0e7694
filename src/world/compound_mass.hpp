// How the mass of a compound lies among its parts.
#pragma once

#include <span>

#include "world/compound.hpp"

namespace unibody {

// What counts where parts overlap: the mass of each of them, or that of the first of them in their order.
enum class Overlap : std::uint8_t { twice, once };

struct CompoundMass {
  double volume = 0;  // m^3
  double mass = 0;    // kg
  Vec3 centre = Vec3::Zero();
  Mat3 second = Mat3::Zero();  // m^2, of the mass about the centre, per mass
};

// densities: kg/m^3, of each part. Parts are summed by closed formulas; what overlaps is taken out of the later part by counting
// the middles of 10^6 cells of the box in which it lies, which is good to some 1e-3 of that overlap.
CompoundMass compound_mass(std::span<const Compound::Part> parts, std::span<const double> densities, Overlap overlap);

}  // namespace unibody
