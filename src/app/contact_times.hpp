// Whether the steps follow contacts that give way.
#pragma once

#include <string>
#include <vector>

#include "step/simulation.hpp"

namespace unibody {

// A warning for each pair of materials whose contacts are over within twenty steps, by the lightest bodies that are there.
// Collective; the same on every rank.
std::vector<std::string> unresolved_contacts(const Simulation& simulation);

}  // namespace unibody
