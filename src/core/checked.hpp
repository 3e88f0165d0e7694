// Return codes that nobody ignores: every call of MPI stands in check_mpi(), every call of PETSc in check_petsc(), every call of
// HDF5 in h5::check() or an h5::Handle (core/hdf5.hpp). tests/program/return_codes.py finds a call that does not.
//
// A failure of MPI or PETSc is seen where no rank foresaw it, and perhaps by one rank alone. The others must not wait for that
// rank, so that these functions do not throw: they say on stderr what failed and where, and end the program on all ranks with
// exit code 3. The last checkpoint is kept. For the same reason they may stand in destructors.
#pragma once

#include <mpi.h>

#include <cstddef>
#include <string>

namespace unibody {

// Says "unibody: rank R: WHAT (FILE:LINE)" and ends the program on all ranks with exit code 3.
[[noreturn]] void end_all_ranks(const std::string& what, const char* file, int line);

[[noreturn]] void fail_mpi(int code, const char* file, int line);
[[noreturn]] void fail_petsc(int code, const char* file, int line);

inline void check_mpi(int code, const char* file = __builtin_FILE(), int line = __builtin_LINE()) {
  if (code != MPI_SUCCESS) fail_mpi(code, file, line);
}

// code: a PetscErrorCode; 0 is success.
inline void check_petsc(int code, const char* file = __builtin_FILE(), int line = __builtin_LINE()) {
  if (code != 0) fail_petsc(code, file, line);
}

// A number of records as the int that MPI takes; ends the program where it does not fit.
int mpi_count(std::size_t count, const char* file = __builtin_FILE(), int line = __builtin_LINE());

}  // namespace unibody
