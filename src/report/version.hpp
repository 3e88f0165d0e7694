// Which program this is, and what it was built with and runs on.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace unibody {

// Pairs of what and which: unibody (its version), commit, compiler, petsc, mpi, hdf5, metis. After MPI_Init.
std::vector<std::pair<std::string, std::string>> versions();

// The same, a line each, for -version.
std::string version_text();

}  // namespace unibody
