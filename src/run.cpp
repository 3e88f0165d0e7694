#include "run.hpp"

#include <petscsys.h>

#include <cstdio>

#include "build.hpp"
#include "core/phases.hpp"
#include "partition/balance.hpp"
#include "report/state_hash.hpp"
#include "step.hpp"

namespace unibody {

int run(MPI_Comm comm, const Options& options) {
  int rank = 0;
  MPI_Comm_rank(comm, &rank);
  if (options.help) {
    if (rank == 0) std::fputs(help_text().c_str(), stdout);
    return 0;
  }
  const Scene scene = read_scene(options.scene, options.overrides);
  PetscInitializeNoArguments();
  PhaseClock clock;
  Simulation simulation(comm, scene, clock);
  simulation.world = build_world(comm, scene);
  simulation.set_tolerance_from_bodies();
  Balance balance(comm, options.random_partition, options.rebalance);
  simulation.move_homes(balance.homes(simulation.world, {}));
  for (std::int64_t frame = 1; frame <= scene.time.frames; ++frame) {
    StepReport report;
    for (int s = 0; s < scene.time.substeps; ++s) report = simulation.step();
    simulation.detect();
    double worst = 0;
    for (const ContactPoint& p : simulation.contacts.points) worst = std::max(worst, -p.gap);
    const double imbalance = balance.imbalance(simulation.world, simulation.contacts);
    if (rank == 0 && frame % 20 == 0)
      std::printf("%ld it %d res %.2e pen %.2e sliding %ld points %zu imb %.3f | collide %.3f solve %.3f halo %.3f part %.3f\n", frame, report.iterations,
                  report.residual, worst, report.sliding, simulation.contacts.points.size(), imbalance, clock[Phase::collide], clock[Phase::solve],
                  clock[Phase::halo], clock[Phase::partition]);
    if (balance.due() && frame % 10 == 0) {
      simulation.move_homes(balance.homes(simulation.world, simulation.contacts));
      balance.changed();
    }
  }
  const auto hash = state_hash(comm, simulation.world);
  if (rank == 0) std::printf("state %016lx\n", hash);
  return 0;
}

}  // namespace unibody
