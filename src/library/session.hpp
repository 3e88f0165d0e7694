// MPI and PETSc of a process that has this program as a part.
#pragma once

#include <memory>

#include "app/petsc_session.hpp"

namespace unibody {

// Starts MPI, unless the process has started it already, and starts PETSc for this process alone, so that simulations of a few
// processes each can start at any time without waiting for the other processes. The destructor ends what the session has started.
class LibrarySession {
 public:
  explicit LibrarySession(int* argc = nullptr, char*** argv = nullptr);
  ~LibrarySession();
  LibrarySession(const LibrarySession&) = delete;
  LibrarySession& operator=(const LibrarySession&) = delete;

 private:
  bool starts_mpi_ = false;
  std::unique_ptr<PetscSession> petsc_;
};

}  // namespace unibody
