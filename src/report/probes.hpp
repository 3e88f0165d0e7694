// What the scene's probes find, frame by frame.
#pragma once

#include <mpi.h>

#include <span>
#include <vector>

#include "report/stretch.hpp"
#include "scene/probe.hpp"
#include "world/world.hpp"

namespace unibody {

// A body is where its centre is. Through a flow's disc goes what is behind it at the start of a frame and before it at the end,
// where the straight way between the two crosses it; what goes back counts as negative.
class Probes {
 public:
  explicit Probes(std::span<const Probe> probes) : probes_(probes) {}

  // Between this and columns() bodies keep their ranks.
  void start_frame(const World& world);

  // Of each probe count (1) and mass (kg); of a flow also the momentum along its normal (kg m/s), all per frame; of a box the
  // mean velocity by mass (m/s), no value where nothing is in it. The same bits on any number of ranks. Collective.
  std::vector<NamedValue> columns(MPI_Comm comm, const World& world) const;

 private:
  std::span<const Probe> probes_;
  std::vector<Vec3> start_;  // m, of home bodies; empty where no probe is a flow
};

}  // namespace unibody
