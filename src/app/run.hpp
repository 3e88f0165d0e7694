// One run: read, build, partition, then step, measure and write, frame by frame.
#pragma once

#include <mpi.h>

#include "app/options.hpp"

namespace unibody {

// Returns the exit code. Throws InputError before anything is written, RunError when the run has to stop. Collective.
int run(MPI_Comm comm, const Options& options);

}  // namespace unibody
