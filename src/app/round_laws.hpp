// Laws of contact that hold where one of two bodies is round: what a scene asks for that has no effect.
#pragma once

#include <string>
#include <vector>

#include "step/simulation.hpp"

namespace unibody {

// A warning for each pair of materials that has an elastic modulus, a surface energy or a volume of liquid, and of which two
// bodies may meet, at least one of them dynamic, that are both no sphere, disc or particle. Collective.
std::vector<std::string> laws_without_effect(const Simulation& simulation);

}  // namespace unibody
