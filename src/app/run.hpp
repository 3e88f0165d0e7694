// One run: read, build, partition, then step, measure and write, frame by frame.
#pragma once

#include <mpi.h>

#include "app/options.hpp"

namespace unibody {

inline constexpr int exit_stopped = 4;  // as asked, by a signal or a limit of time

// Returns the exit code: 0 or exit_stopped. Throws InputError before anything is written, RunError when the run has to stop.
// Collective.
int run(MPI_Comm comm, const Options& options);

}  // namespace unibody
