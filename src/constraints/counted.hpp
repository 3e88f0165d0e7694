// Several ranks may know of a constraint; one of them counts it.
#pragma once

#include "constraints/constraint_types.hpp"
#include "world/world.hpp"

namespace unibody {

// Whether this rank is the one that counts a constraint: its first body that moves is home here. `world` needs no guests.
template <class C>
bool counts_here(const World& world, const Constraint<C>& c) {
  for (const Id id : c.ids)
    if (const Slot slot = world.find(id); slot < 0 || !world.is_static(slot)) return slot >= 0 && world.is_home(slot);
  return false;
}

}  // namespace unibody
