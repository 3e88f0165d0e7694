// What is said of a state that is no longer finite.
#pragma once

#include <mpi.h>

#include "step/simulation.hpp"

namespace unibody {

// Throws RunError on every rank where the state of a body is not finite: it names the one with the smallest id, and a constraint
// that acts on it. `substep`: of the frame, from 0. Collective.
void stop_if_not_finite(MPI_Comm comm, const Scene& scene, const Simulation& simulation, std::int64_t frame, int substep);

}  // namespace unibody
