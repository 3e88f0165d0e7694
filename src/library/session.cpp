#include "library/session.hpp"

#include <mpi.h>
#include <petscsys.h>

#include "core/before_mpi.hpp"
#include "core/checked.hpp"
#include "core/memory.hpp"

namespace unibody {

LibrarySession::LibrarySession(int* argc, char*** argv) {
  give_freed_memory_back();
  choose_for_mpi();
  int runs = 0;
  check_mpi(MPI_Initialized(&runs));
  starts_mpi_ = runs == 0;
  if (starts_mpi_) check_mpi(MPI_Init(argc, argv));
  PetscBool petsc_runs = PETSC_FALSE;
  check_petsc(PetscInitialized(&petsc_runs));
  if (petsc_runs == PETSC_FALSE) PETSC_COMM_WORLD = MPI_COMM_SELF;
  petsc_ = std::make_unique<PetscSession>(MPI_COMM_SELF, std::vector<std::string>{"-no_signal_handler"});
}

LibrarySession::~LibrarySession() {
  petsc_.reset();
  int ended = 0;
  static_cast<void>(MPI_Finalized(&ended));  // in vain where they fail: a destructor has no one to tell
  if (starts_mpi_ && ended == 0) static_cast<void>(MPI_Finalize());
}

}  // namespace unibody
