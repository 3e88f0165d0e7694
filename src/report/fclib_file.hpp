// A step's frictional contact problem in the HDF5 form of FCLIB (https://frictionalcontactlibrary.github.io), both ways that it
// knows, with the step's own solution:
//
//   /fclib_local/{W, vectors/{q, mu}, spacedim, info}         u = W r + q
//   /fclib_global/{M, H, vectors/{f, w, mu}, spacedim, info}  M v = H r + f, u = H^T v + w
//   /solution/{v, u, r}  /guesses/{number_of_guesses, 1/{v, u, r}}
//   /unibody/{bodies, contacts}  ids of the bodies, and of each contact's two bodies; FCLIB does not read it
#pragma once

#include <mpi.h>

#include <string>

#include "step/contact_problem.hpp"

namespace unibody {

// Throws InputError on every rank where the file cannot be written, or exists and must not be overwritten. Collective.
void check_fclib_path(MPI_Comm comm, const std::string& path, bool overwrite);

// Writes what rank 0 holds, under a temporary name first. Collective; throws RunError on every rank.
void write_fclib(MPI_Comm comm, const std::string& path, const ContactProblem& problem, const std::string& title,
                 const std::string& description);

}  // namespace unibody
