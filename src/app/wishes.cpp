#include "app/wishes.hpp"

#include <petscsys.h>

#include <algorithm>
#include <cstdio>

#include "core/checked.hpp"
#include "core/errors.hpp"
#include "report/fclib_file.hpp"

namespace unibody {

void check_wishes(MPI_Comm comm, const Scene& scene, const Options& options, std::int64_t first_frame) {
  if (options.error_estimate > 0 && scene.solver.name == "newton")
    throw InputError("option -error_estimate: found solver.name newton, expected an iterative solver (newton converges)");
  if (options.dump_fclib.empty()) return;
  if (!scene.constraint_groups.empty() || !scene.attachments.empty() || !scene.joints.empty())
    throw InputError("option -dump_fclib: found joints, cloths, threads or solids in " + scene.path +
                     ", expected rigid bodies that touch, alone");
  for (std::size_t k = 0; k < pair_value_types.size(); ++k)
    if (!pair_value_types[k].in_contact_problem && scene.pairs.any(static_cast<PairValue>(k)))
      throw InputError("option -dump_fclib: found " + std::string(pair_value_types[k].key) + " in " + scene.path +
                       ", expected none");
  if (std::ranges::any_of(scene.groups, [](const BodyGroup& group) { return group.friction.has_value(); }))
    throw InputError("option -dump_fclib: found anisotropic_friction in " + scene.path + ", expected none");
  if (scene.planar) throw InputError("option -dump_fclib: found a planar scene, expected bodies free in space");
  if (first_frame >= scene.time.frames)
    throw InputError("option -dump_fclib: the run starts with its last frame, " + std::to_string(first_frame) +
                     ": there is no step to write, expected more time.frames");
  if (options.dump_step > scene.time.frames || (options.dump_step >= 0 && options.dump_step <= first_frame))
    throw InputError("option -dump_step: found " + std::to_string(options.dump_step) + ", expected a frame of the run, " +
                     std::to_string(first_frame + 1) + " to " + std::to_string(scene.time.frames));
  check_fclib_path(comm, options.dump_fclib, options.overwrite);
}

bool dump_problem(MPI_Comm comm, const Scene& scene, const Options& options, std::int64_t frame, const ContactProblem& problem) {
  int contacts = static_cast<int>(problem.contacts.size());
  check_mpi(MPI_Bcast(&contacts, 1, MPI_INT, 0, comm));
  if (contacts == 0) {
    int rank = 0;
    check_mpi(MPI_Comm_rank(comm, &rank));
    if (rank == 0)
      std::fprintf(stderr, "unibody: -dump_fclib: frame %lld has no contacts: no file\n", static_cast<long long>(frame));
    return false;
  }
  const std::string text = "Unibody, last step of frame " + std::to_string(frame) + " of " + scene.path;
  write_fclib(comm, options.dump_fclib, problem, scene.title, text);
  return true;
}

// The global vectors hold four numbers a body at most, which PETSc counts as PetscInt.
void check_petsc_counts(const Scene& scene) {
  constexpr Id most = PETSC_MAX_INT / 4;
  if (scene.body_count() > most)
    throw InputError(scene.path + ": found " + std::to_string(scene.body_count()) + " bodies, expected at most " +
                     std::to_string(most) + ": this PETSc counts with " + std::to_string(8 * sizeof(PetscInt)) +
                     " bits (one that was built with --with-64-bit-indices counts further)");
}

}  // namespace unibody
