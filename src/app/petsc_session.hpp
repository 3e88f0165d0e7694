// PETSc, from its start to its end, with the options of the command line that are its own. Where PETSc runs already, of a program
// that has this one as a part, it is neither started nor ended.
#pragma once

#include <mpi.h>

#include <string>
#include <vector>

namespace unibody {

class PetscSession {
 public:
  // Collective. Starts PETSc, then makes a small vector and brings its values to the next rank, in the way of the halo, so that
  // options that PETSc cannot work with are found before the run. Throws InputError on every rank where there are such options.
  PetscSession(MPI_Comm comm, const std::vector<std::string>& options);
  ~PetscSession();
  PetscSession(const PetscSession&) = delete;
  PetscSession& operator=(const PetscSession&) = delete;

  // Says on stderr, by rank 0, which of the options PETSc never looked at: it takes any word.
  void name_unused_options() const;

 private:
  void try_options() const;

  MPI_Comm comm_;
  bool starts_ = true;
  std::vector<std::string> words_;
  std::vector<char*> argv_;
};

}  // namespace unibody
