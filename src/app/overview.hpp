// What a run is about to do, told before its first frame, and what in the scene is probably a mistake.
#pragma once

#include <string>
#include <vector>

#include "step/simulation.hpp"

namespace unibody {

struct Overview {
  std::vector<std::string> lines;     // bodies, their place, what ties them, the run and its plan
  std::vector<std::string> warnings;  // each names what it is about and what to do
};

// The overview of a simulation whose contacts have been found. Collective; the same on every rank.
Overview overview_of(const Simulation& simulation);

}  // namespace unibody
