// Shapes that move as one body.
#pragma once

#include <span>

#include "world/shapes.hpp"
#include "world/solid_moments.hpp"

namespace unibody {

struct Compound {
  struct Part {
    Shape shape;  // convex
    Vec3 place;   // m, of its centre from the body's, in the body's axes
    Quat turn;    // its axes -> the body's
  };
  std::vector<Part> parts;
  Vec3 size = Vec3::Zero();       // m, the largest of each coordinate
  double radius = 0;              // m, of a sphere about the centre that holds it
  double smallest = 0;            // m, the shortest edge of the box that holds it
  double volume = 0;              // m^3
  double mass = 0;                // kg, by the densities of its parts; 0: they have none
  Vec3 inertia = Vec3::Zero();    // m^2, principal moments per mass
  Quat frame = Quat::Identity();  // principal axes -> axes in which the parts were given
  Vec3 centre = Vec3::Zero();     // m, the centre of mass among the parts as given
};

// Makes a compound of one density throughout, in which the mass of parts counts twice where they overlap (compound_mass.hpp has
// other ways); or, with the moments given, one whose parts stand for a solid.
Compound make_compound(std::span<const Compound::Part> parts);
Compound make_compound(std::span<const Compound::Part> parts, const SolidMoments& moments);

// A convex solid or a compound, in the axes in which it is given, as a compound of other mass properties.
Compound with_moments(const Shape& shape, const SolidMoments& moments);

// kg, of a compound whose parts have densities; of other shapes 0.
double own_mass(const Shape& shape);

}  // namespace unibody
