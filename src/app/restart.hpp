// How a run goes on from a checkpoint: what must be as it was, and the world at that time.
#pragma once

#include <mpi.h>

#include <string>

#include "app/options.hpp"
#include "step/simulation.hpp"

namespace unibody {

// What must not change between a checkpoint and the run that goes on from it, the settings last. How long the run is, and what it
// writes, may.
std::string mark_of(const Scene& scene, bool with_settings = true);

// The world at the checkpoint that the options name: each rank reads its share of the moving bodies, and all statics. Returns the
// checkpoint's frame. Throws InputError where the scene is another. Collective.
std::int64_t restore(MPI_Comm comm, Scene& scene, const Options& options, Simulation& simulation);

}  // namespace unibody
