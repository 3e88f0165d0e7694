// Which couplings of joints a rank has to do with.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "joints/coupling.hpp"
#include "joints/joint.hpp"
#include "world/world.hpp"

namespace unibody {

// The couplings with a home body here, ascending.
JointList couplings_here(std::span<const Coupling> couplings, const World& world);

// Their bodies that are of other ranks, ascending; mutual between ranks. `world` has no guests yet.
std::vector<Id> partners(std::span<const Coupling> couplings, const JointList& list, const World& world);

// The slots of their bodies, all of which are here. A coupling is counted where the first of its bodies that moves is home.
std::vector<CouplingSlots> coupling_slots(std::span<const Coupling> couplings, const JointList& list, const World& world,
                                          Slot nobody);

// Gives each coupling the smallest colour that none before it has at its moving bodies. Returns how many colours there are.
std::int32_t colour_couplings(std::span<Coupling> couplings, const std::function<bool(Id)>& is_static);

}  // namespace unibody
