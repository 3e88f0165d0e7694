// What a run that goes on does with result files that a crash of the machine, or a kill in the middle of a write, left
// unreadable.
#pragma once

#include <mpi.h>

#include <string>
#include <vector>

namespace unibody {

// Looks at frames.h5, joints.h5 and contacts.h5 of the folder. Where one is there but HDF5 cannot read it or one of its frames,
// gives it a name beside (frames-damaged.h5, frames-damaged-2.h5, ...), so that nothing is lost and the run can begin a new one.
// Returns a warning for each, on rank 0; throws RunError on every rank where a file cannot be renamed. Collective.
std::vector<std::string> set_aside_damaged_files(MPI_Comm comm, const std::string& directory);

}  // namespace unibody
