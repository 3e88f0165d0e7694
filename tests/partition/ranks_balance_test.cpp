// Rebalancing: where the work has moved to one side the ranks share it out anew, and no result depends on it.
#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

#include "partition/balance.hpp"
#include "partition/ranks.hpp"
#include "report/state_hash.hpp"
#include "small_worlds.hpp"
#include "step/step_parts.hpp"

namespace unibody::small_worlds::ranks_balance_test {

namespace {

// Two blocks of 240 boxes side by side: the left one comes down on the ground at once, the right one has far to fall. At the
// start nothing touches anything, and each half of the ranks has one of them.
const char* const scene_text = R"(
bodies:
  - shape: {plane: {normal: [0, 0, 1]}}
  - lattice: {count: 240, columns: [20, 4], spacing: [0.13, 0.13, 0.155], height: 0.08, jitter: 0.004}
    shape: {box: {size: [0.12, 0.12, 0.15]}}
    mass: 1
  - lattice: {count: 240, columns: [10, 4], spacing: [0.3, 0.3, 0.3], height: 0.2}
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
  s.move_homes(balance.homes(parts_of(s)));
  Outcome outcome;
  constexpr int frames = 16;
  for (int frame = 0; frame < frames; ++frame) {
    if (balance.due()) {
      const std::vector<int> homes = balance.homes(parts_of(s));
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
    const double imbalance = balance.imbalance(parts_of(s));
    if (frame >= frames / 2) outcome.imbalance += imbalance / (frames / 2);
  }
  outcome.hash = state_hash(comm, s.world);
  return outcome;
}

// Of a rank's count of something: the largest over the mean.
double largest_over_mean(std::size_t count) {
  auto most = static_cast<double>(count), sum = most;
  MPI_Allreduce(MPI_IN_PLACE, &most, 1, MPI_DOUBLE, MPI_MAX, MPI_COMM_WORLD);
  MPI_Allreduce(MPI_IN_PLACE, &sum, 1, MPI_DOUBLE, MPI_SUM, MPI_COMM_WORLD);
  return most * rank_count() / sum;
}

// Two sheets that lie on each other, and a chain on the ground.
const char* const sheets_and_chain = R"(
bodies:
  - shape: {plane: {normal: [0, 0, 1]}}
  - name: chain
    shape: {box: {size: [0.09, 0.03, 0.02]}}
    mass: 0.1
    position: [0, 9, 0.0101]
    chain: {count: 13, from: [0, 0, 0], to: [1.3, 0, 0], held: start, joint: {type: ball}}
cloths:
  - {grid: {size: [1.9, 1.9], nodes: [20, 20]}, mass: 1, thickness: 0.02, links: {}, position: [0, 0, 5]}
  - {grid: {size: [1.9, 1.9], nodes: [20, 20]}, mass: 1, thickness: 0.02, links: {}, position: [0.03, 0.02, 5.021]}
)";

}  // namespace

TEST(RanksBalance, EvensTheWorkThatHasGatheredOnOneSide) {
  const int ranks = rank_count();
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

// A chain whose 40 joints are nearly all of the work, and spheres far off that are most of the bodies to one side of it.
TEST(RanksBalance, EvensJoints) {
  Experiment run(scene_from_text(R"(
bodies:
  - shape: {plane: {normal: [0, 0, 1]}}
  - name: chain
    shape: {box: {size: [0.09, 0.03, 0.02]}}
    mass: 0.1
    position: [0, 0, 3]
    chain: {count: 40, from: [0, 0, 0], to: [4, 0, 0], held: start, joint: {type: ball}}
  - lattice: {count: 30, columns: [5, 3], spacing: [0.3, 0.3, 0.3], height: 1}
    shape: {sphere: {radius: 0.1}}
    mass: 1
    position: [30, 0, 0]
)"),
                 MPI_COMM_WORLD);
  Simulation& s = *run.simulation;
  Balance balance(MPI_COMM_WORLD, std::nullopt, true);
  s.make_constraints();
  s.move_homes(balance.homes(parts_of(s)));
  s.detect();
  // Two ranks both evaluate the joint at their cut; cells hold three or four links.
  EXPECT_LT(largest_over_mean(s.ties.joints.size()), 1.35);
  const double even = balance.imbalance(parts_of(s));
  EXPECT_LT(even, 1.35);
  s.move_homes(std::vector<int>(s.world.homes, 0));  // the chain on one rank, however few its bodies
  s.detect();
  EXPECT_NEAR(balance.imbalance(parts_of(s)), rank_count(), 0.05 * rank_count());
}

// What bodies are said to cost sums up, over the ranks of any partition, to the work of one rank that has them all; and contacts
// of surfaces and joints are part of it.
TEST(RanksBalance, CostsOfBodiesSumUpToTheWork) {
  Experiment alone(scene_from_text(sheets_and_chain)), run(scene_from_text(sheets_and_chain), MPI_COMM_WORLD);
  Simulation& s = *run.simulation;
  s.make_constraints();
  s.move_homes(Balance(MPI_COMM_WORLD, 3, false).homes(parts_of(s)));
  s.detect(), alone.simulation->detect();
  const std::vector<float> costs = work_by_body(parts_of(s));
  double sum = std::accumulate(costs.begin(), costs.end(), 0.0);
  MPI_Allreduce(MPI_IN_PLACE, &sum, 1, MPI_DOUBLE, MPI_SUM, MPI_COMM_WORLD);
  const StepParts all = parts_of(*alone.simulation);
  const double whole = work_of(all);
  EXPECT_NEAR(sum, whole, 1e-5 * whole) << "float's rounding";
  ASSERT_GT(all.contacts.surface.size(), 100u);
  ASSERT_EQ(all.joints_here.size(), 13u);
  ASSERT_GT(all.contacts.manifolds.size(), 0u);
  Contacts without = all.contacts;
  without.surface.clear();
  const double rigid = work_of({all.world, without, all.constraints, all.joints, all.joints_here});
  EXPECT_NEAR(whole - rigid, work::of_a_surface_contact * static_cast<double>(all.contacts.surface.size()), 1e-9 * whole);
  EXPECT_NEAR(rigid - work_of({all.world, without, all.constraints}), 13 * 3 * work::of_a_joint_row, 1e-9 * whole);
}

}  // namespace unibody::small_worlds::ranks_balance_test
