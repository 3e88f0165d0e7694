// What a simulation's step evaluates, as the balance of its ranks counts it.
#pragma once

#include "partition/work.hpp"
#include "step.hpp"

namespace unibody {

// Contacts are those of the last detect(); before it there are none.
inline StepParts parts_of(const Simulation& simulation, const Scene& scene) {
  return {simulation.world, simulation.contacts, &simulation.constraints, scene.joints, simulation.joints};
}

}  // namespace unibody
