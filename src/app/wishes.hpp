// What options ask of a run beside the run itself: whether the scene allows it, and the problem of -dump_fclib.
#pragma once

#include <mpi.h>

#include "app/options.hpp"
#include "scene/scene.hpp"
#include "step/contact_problem.hpp"

namespace unibody {

// Throws InputError where the scene or its solver cannot do what an option asks for. Collective.
void check_wishes(MPI_Comm comm, const Scene& scene, const Options& options, std::int64_t first_frame);

// Throws InputError where the scene has more bodies than PETSc can count.
void check_petsc_counts(const Scene& scene);

// Writes the problem of that frame; returns whether there was anything to write. Collective.
bool dump_problem(MPI_Comm comm, const Scene& scene, const Options& options, std::int64_t frame, const ContactProblem& problem);

}  // namespace unibody
