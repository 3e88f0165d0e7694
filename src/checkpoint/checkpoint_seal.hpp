// The seal of a checkpoint: its first 512 bytes, which HDF5 leaves alone, hold the length and a hash of all that follows.
//
// HDF5 guards some of its own records by checksums, but not the data, and it is not made to be fed with damaged files: it may
// crash on them. The seal is therefore compared before HDF5 sees the file, and what passes holds the bytes that were written.
#pragma once

#include <mpi.h>

#include <cstdint>
#include <string>

namespace unibody {

inline constexpr std::uint64_t seal_bytes = 512;

// Writes the seal of a file that is otherwise finished. All ranks hash a share of the file; the seal does not depend on how many
// there are. Collective; throws std::runtime_error on every rank.
void seal_file(MPI_Comm comm, const std::string& path);

// Throws std::runtime_error on every rank unless the file holds what was sealed. Collective.
void check_seal(MPI_Comm comm, const std::string& path);

}  // namespace unibody
