// Gauss-Seidel: every contact acts on the velocities that the ones before it have left. Coloured, so that the same sweep runs
// four contacts at a time and on any number of ranks. Every second sweep goes through the colours of contacts backwards, which
// halves its bias; all else always goes forwards: backwards the last colour would be solved twice in a row, which of few colours
// wastes much (twice the stretch of a cloth). Contacts of surfaces are one group more, within which all move at once, by masses
// split among them, and therefore some times over; attachments are another, and so are the trees of joints that are solved
// directly.

#include <mpi.h>

#include "constraints/constraint_batches.hpp"
#include "core/checked.hpp"
#include "solve/solver.hpp"

namespace unibody {

namespace {

constexpr int surface_sweeps = 4;  // in each iteration; with one, five cloths on each other are not held apart

}  // namespace

SolveReport gauss_seidel(System& system, const Cut& cut, int iterations, double tolerance) {
  SolveReport report;
  const std::size_t colours = system.contacts.group_count();
  while (report.iterations < iterations && !report.converged) {
    if (system.before_iteration) {
      cut.exchange(system.bodies);
      system.before_iteration();
    }
    const bool backwards = report.iterations % 2 == 1;
    double change = 0;
    const std::size_t attachments = colours + (system.any_surface ? 1 : 0);
    const std::size_t constraints = attachments + (system.attachments ? 1 : 0);
    const std::size_t joints = constraints + (system.constraints ? system.constraints->group_count() : 0);
    const std::size_t trees = joints + (system.joints ? system.joints->colour_count() : 0);
    const std::size_t groups = trees + (system.joints && system.any_tree ? 1 : 0);
    for (std::size_t i = 0; i < groups; ++i) {
      const std::size_t group = backwards && i < colours ? colours - 1 - i : i;
      if (group < colours) {
        cut.exchange_colour(group, system.bodies);
        change = std::max(change, system.contacts.relax(group, backwards, system.bodies));
        change = std::max(change, system.rolling.relax(group, system.contacts, system.bodies));
      } else if (group < constraints) {
        const bool of_surfaces = group < attachments;
        for (int k = 0; k < (of_surfaces ? surface_sweeps : 1); ++k) {
          cut.exchange(system.bodies);
          SweepSums sums;
          if (of_surfaces)
            system.surface.sweep_jacobi(system.bodies, system.wrenches, {}, sums);
          else
            system.attachments->sweep_jacobi(system.bodies, system.wrenches, {}, sums);
          system.apply_wrenches();
          change = std::max(change, sums.change);
        }
      } else if (group >= trees) {
        cut.exchange(system.bodies);
        change = std::max(change, system.joints->relax_trees(system.bodies));
      } else if (group >= joints) {
        cut.exchange_joints(group - joints, system.bodies);
        change = std::max(change, system.joints->relax(group - joints, system.bodies));
      } else {
        cut.exchange_group(group - constraints, system.bodies);
        change = std::max(change, system.constraints->relax(group - constraints, system.start(), system.bodies));
      }
    }
    ++report.iterations;
    if (tolerance <= 0) continue;
    check_mpi(MPI_Allreduce(&change, &report.residual, 1, MPI_DOUBLE, MPI_MAX, cut.comm()));
    report.converged = report.residual <= tolerance;
  }
  system.contacts.hold_centres(system.homes, system.first_static, system.bodies);
  cut.exchange(system.bodies);
  return report;
}

}  // namespace unibody
