// What one point of contact did in a step.
#pragma once

#include <array>

#include "core/types.hpp"

namespace unibody {

// Two bodies that touch have the first two ends, with shares of 1 and -1. A contact of a cloth, thread or solid has up to four: a
// side that is a face, an edge or a segment takes the impulse with its nodes, by their shares.
struct ContactImpulse {
  std::array<Id, 4> ids{-1, -1, -1, -1};  // of the ends; -1: none
  std::array<double, 4> shares{};         // of the first side positive, sum 1; of the second negative, sum -1
  Vec3 point;                             // m, world, at the start of the step
  std::array<Vec3, 2> sides;              // m, of each side the centre, or the point itself where the scene moves or holds it
  Vec3 normal;                            // world, unit, from the second side to the first
  Vec3 impulse;                           // N s, world, on the first side; the second takes the opposite
  double friction = 0;                    // Coulomb's mu of the pair
};

}  // namespace unibody
