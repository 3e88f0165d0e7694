// MPI and PETSc of a process that has this program as a part.
#pragma once

#include <memory>

#include "app/petsc_session.hpp"

namespace unibody {

// Starts MPI where nothing else has, and PETSc for this process alone: simulations of a few processes each may start at any time,
// and none waits for processes that have none. What it has started it ends.
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
