// MPI and PETSc of a Python process: who starts and who ends them.
#pragma once

#include <mpi.h>
#include <pybind11/pybind11.h>

namespace unibody {

// Starts MPI where nothing else has (mpi4py starts it when it is imported), and PETSc for this process alone. Once a process;
// what was started here ends when Python ends, after the simulations that are still open then (`close_all`).
void start_mpi(const pybind11::object& close_all);

// The communicator of an mpi4py object; of None all of the processes that mpirun started. Throws InputError for anything else.
MPI_Comm communicator_of(const pybind11::object& comm);

}  // namespace unibody
