// What must hold of the contacts that collision detection hands to the solver.
#pragma once

#include <string>

#include "collide/contacts.hpp"
#include "world/world.hpp"

namespace unibody {

// A sentence about the first contact of which something does not hold: keys in ascending order, slots that hold the bodies of the
// key, points within the list, unit normals, finite gaps. Empty where all of it holds.
std::string fault_of(const Contacts& contacts, const World& world);

}  // namespace unibody
