// Rebalancing: where the work has moved to one side the ranks share it out anew, and no result depends on it.
#include <gtest/gtest.h>

#include <algorithm>

#include "partition/balance.hpp"
#include "report/state_hash.hpp"
#include "small_worlds.hpp"

namespace unibody::small_worlds {

namespace {

// Two blocks of 120 boxes side by side: the left one comes down on the ground at once, the right one has far to fall. At the
// start nothing touches anything, and each half of the ranks has one of them.
const char* const scene_text = R"(
bodies:
  - shape: {plane: {normal: [0, 0, 1]}}
  - lattice: {count: 120, columns: [10, 4], spacing: [0.13, 0.13, 0.155], height: 0.08, jitter: 0.004}
    shape: {box: {size: [0.12, 0.12, 0.15]}}
    mass: 1
  - lattice: {count: 120, columns: [10, 4], spacing: [0.3, 0.3, 0.3], height: 0.2}
    shape: {box: {size: [0.12, 0.12, 0.15]}}
    mass: 1
    position: [4, 0, 5]
solver: {iterations: 4}
)";

struct Outcome {
  int changes = 0;         // of homes after the start
  std::int64_t moved = 0;  // bodies, over all ranks
  double imbalance = 0;    // mean of the second half of the frames
  std::uint64_t hash = 0;
};

// As a run does it, frame by frame.
Outcome simulate(MPI_Comm comm, bool rebalance) {
  Experiment run(scene_from_text(scene_text), comm);
  Simulation& s = *run.simulation;
  Balance balance(comm, std::nullopt, rebalance);
  s.move_homes(balance.homes(s.world, {}));
  Outcome outcome;
  constexpr int frames = 16;
  for (int frame = 0; frame < frames; ++frame) {
    if (balance.due()) {
      const std::vector<int> homes = balance.homes(s.world, s.contacts);
      int rank = 0;
      MPI_Comm_rank(comm, &rank);
      std::int64_t moved = std::count_if(homes.begin(), homes.end(), [&](int home) { return home != rank; });
      MPI_Allreduce(MPI_IN_PLACE, &moved, 1, MPI_INT64_T, MPI_SUM, comm);
      outcome.moved += moved, ++outcome.changes;
      s.move_homes(homes);
      balance.changed();
    }
    run.step();
    s.detect();
    const double imbalance = balance.imbalance(s.world, s.contacts);
    if (frame >= frames / 2) outcome.imbalance += imbalance / (frames / 2);
  }
  outcome.hash = state_hash(comm, s.world);
  return outcome;
}

}  // namespace

TEST(RanksBalance, EvensTheWorkThatHasGatheredOnOneSide) {
  int ranks = 1;
  MPI_Comm_size(MPI_COMM_WORLD, &ranks);
  const Outcome on = simulate(MPI_COMM_WORLD, true), off = simulate(MPI_COMM_WORLD, false);
  EXPECT_EQ(on.hash, off.hash);
  EXPECT_EQ(on.hash, simulate(MPI_COMM_SELF, true).hash);
  EXPECT_EQ(off.changes, 0);
  if (ranks == 1) {
    EXPECT_EQ(on.changes, 0);
    return;
  }
  EXPECT_GE(on.changes, 1);
  EXPECT_LE(on.changes, 4) << "it has its price";
  EXPECT_GT(on.moved, 10);
  EXPECT_GT(off.imbalance, 1.3) << "too even a scene tells nothing";
  EXPECT_LT(on.imbalance - 1, 0.5 * (off.imbalance - 1));
}

}  // namespace unibody::small_worlds
