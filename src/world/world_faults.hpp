// What must hold of the arrays of bodies between any two parts of a step.
#pragma once

#include <string>

#include "world/world.hpp"

namespace unibody {

// A sentence about the first body of which something does not hold: arrays of one length, ids in ascending order in each of the
// three ranges, finite states, orientations of length 1 within 1e-6. Empty where all of it holds.
std::string fault_of(const World& world);

}  // namespace unibody
