// Return codes that nobody ignores: every call of MPI stands in check_mpi(), every call of PETSc in check_petsc(), every call of
// HDF5 in h5::check() or an h5::Handle (core/hdf5.hpp). tests/program/return_codes.py finds a call that does not.
//
// A failure of MPI or PETSc is seen where no rank foresaw it, and perhaps by one rank alone. The others must not wait for that
// rank, so that these functions do not throw: they say on stderr what failed and where, and end the program on all ranks with
// exit code 3. The last checkpoint is kept. For the same reason they may stand in destructors.
#pragma once

#include <mpi.h>

#include <cstddef>
#include <source_location>
#include <string>

namespace unibody {

// Says "unibody: rank R: WHAT (FILE:LINE)" and ends the program on all ranks with exit code 3.
[[noreturn]] void end_all_ranks(const std::string& what, const std::source_location& where);

[[noreturn]] void fail_mpi(int code, const std::source_location& where);
[[noreturn]] void fail_petsc(int code, const std::source_location& where);

inline void check_mpi(int code, const std::source_location& where = std::source_location::current()) {
  if (code != MPI_SUCCESS) fail_mpi(code, where);
}

// code: a PetscErrorCode; 0 is success.
inline void check_petsc(int code, const std::source_location& where = std::source_location::current()) {
  if (code != 0) fail_petsc(code, where);
}

// A number of records as the int that MPI takes; ends the program where it does not fit.
int mpi_count(std::size_t count, const std::source_location& where = std::source_location::current());

}  // namespace unibody
