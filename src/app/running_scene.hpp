// A scene in motion, on all ranks of a communicator: what the program's run and the Python module have in common.
#pragma once

#include <mpi.h>

#include <cstdint>
#include <string>
#include <vector>

#include "app/options.hpp"
#include "core/phases.hpp"
#include "partition/balance.hpp"
#include "scene/scene.hpp"
#include "step/simulation.hpp"

namespace unibody {

// Throws InputError where the scene's solver cannot run on so many ranks. Collective.
void check_ranks_of_solver(MPI_Comm comm, const Scene& scene);

// All members are collective.
class RunningScene {
 public:
  // The scene and the options must outlive it. Of the options it goes by restart, other_settings, random_partition, rebalance and
  // shared_memory alone.
  // Events of the scene change its motors and coefficients of friction.
  RunningScene(MPI_Comm comm, Scene& scene, const Options& options);

  // Makes the bodies, or reads them from the checkpoint that the options name, and gives each to a rank. Returns the frame at
  // which the scene stands then: 0, or the checkpoint's. Throws InputError where the checkpoint is damaged or of another scene.
  std::int64_t start();

  // What start() found to tell, where the scene goes on from another's checkpoint.
  const std::vector<std::string>& told() const { return told_; }

  // What happens between the frame before and this one (from 1): events, inlets and outlets. To be called before its first step.
  void start_frame(std::int64_t frame);

  // The next step, which belongs to this frame (from 1) and is its substep-th (from 0). Throws RunError, with the body named,
  // where the step leads to a state that is not finite, or to surfaces that pass through each other.
  StepReport step(const StepRequest& request, std::int64_t frame, int substep);

  // Moves bodies between ranks where it is worth its price. Between frames, after imbalance().
  void rebalance();
  // The largest work of a rank over the mean; 1: even.
  double imbalance();
  BorderCosts borders() const;

  // Checkpoints will be of the scene as it is now, for whoever changes it later.
  void fix_scene();
  // Throws RunError where the disk fails; the file that was there is then untouched.
  void write_checkpoint(const std::string& path, std::int64_t frame);

  PhaseClock clock;
  Simulation simulation;

 private:
  void stop_if_not_held(const StepReport& report, std::int64_t frame) const;

  MPI_Comm comm_;
  Scene& scene_;
  const Options& options_;
  std::string mark_;  // of the scene, for checkpoints; empty: not needed yet
  Balance balance_;
  std::vector<std::string> told_;
};

}  // namespace unibody
