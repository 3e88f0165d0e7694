// Rolling and spinning friction across ranks: a heap of balls and boxes has the bits of one rank.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "checkpoint/checkpoint.hpp"
#include "partition/balance.hpp"
#include "small_worlds.hpp"
#include "step/step_parts.hpp"

namespace unibody::small_worlds::ranks_rolling_test {

std::vector<int> mixed_homes(const World& world, int turn) {
  int ranks = 1;
  MPI_Comm_size(MPI_COMM_WORLD, &ranks);
  std::vector<int> homes;
  for (std::size_t i = 0; i < world.homes; ++i) homes.push_back(static_cast<int>((world.id[i] + turn) / 3 % ranks));
  return homes;
}

std::string heap(const char* solver) {
  return std::string(R"(
materials:
  a: {friction: 0.5, rolling_friction: 0.01, spinning_friction: 0.003}
  b: {friction: 0.4}
  pairs: [{between: [a, b], friction: 0.6, rolling_friction: 0.02}]
bodies:
  - {shape: {plane: {normal: [0, 0, 1]}}, material: b}
  - {lattice: {count: 40, columns: [3, 3], spacing: [0.21, 0.21, 0.21], height: 0.11, jitter: 0.01}, shape: {sphere: {radius: 0.1}}, mass: 1, angular_velocity: [3, 0, 2]}
  - {lattice: {count: 9, columns: [3, 3], spacing: [0.22, 0.22, 0.21], height: 1.2, rotation_jitter: 0.3}, shape: {box: {size: [0.18, 0.14, 0.1]}}, mass: 2, material: b}
solver: {iterations: 16, name: )") +
         solver + "}\n";
}

TEST(RanksRolling, AHeapHasTheBitsOfOneRank) {
  for (const char* solver : {"accelerated_jacobi", "jacobi", "gauss_seidel"}) {
    const std::string text = heap(solver);
    Experiment alone(scene_from_text(text)), run(scene_from_text(text), MPI_COMM_WORLD);
    run.simulation->move_homes(Balance(MPI_COMM_WORLD, 5, false).homes(parts_of(*run.simulation)));
    for (int k = 0; k < 25; ++k) {
      if (k % 6 == 5) run.simulation->move_homes(mixed_homes(run.world(), k));  // the torques go along
      alone.step(), run.step();
      ASSERT_EQ(run.last.residual, alone.last.residual) << solver << ' ' << k;
      const World& w = run.world();
      for (std::size_t i = 0; i < w.homes; ++i) {
        const BodyState here = w.state(i), there = alone.state(w.id[i]);
        ASSERT_EQ(here.position, there.position) << solver << ' ' << k << ' ' << w.id[i];
        ASSERT_EQ(here.angular_velocity, there.angular_velocity) << solver << ' ' << k << ' ' << w.id[i];
      }
    }
  }
}

// Balls that swing in a trough of nine planks pass from one to the next; those that another rank moves, too.
TEST(RanksRolling, ATroughHasTheBitsOfOneRank) {
  std::string planks = "materials: {m: {friction: 0.3}}\nbodies:\n";
  for (int k = -4; k <= 4; ++k) {
    const double a = 0.15 * k, s = std::sin(a), c = std::cos(a);
    planks += "  - {shape: {box: {size: [0.16, 4, 0.1]}}, motion: fixed, position: [" + std::to_string(1.05 * s) + ", 0, " +
              std::to_string(-1.05 * c) + "], orientation: [" + std::to_string(std::cos(a / 2)) + ", 0, " +
              std::to_string(-std::sin(a / 2)) + ", 0]}\n";
  }
  planks += "  - {shape: {sphere: {radius: 0.1}}, mass: 1, points: [";
  for (int k = 0; k < 16; ++k)
    planks +=
        (k > 0 ? ", [" : "[") + std::to_string(0.35 * std::sin(1.3 * k)) + ", " + std::to_string(-1.6 + 0.202 * k) + ", -0.75]";
  for (const char* solver : {"accelerated_jacobi", "jacobi", "gauss_seidel"}) {
    const std::string text = planks + "]}\nsolver: {iterations: 16, name: " + solver + "}\n";
    Experiment alone(scene_from_text(text)), run(scene_from_text(text), MPI_COMM_WORLD);
    run.simulation->move_homes(mixed_homes(run.world(), 0));
    bool crossed = false;
    for (int k = 0; k < 90; ++k) {
      alone.step(), run.step();
      crossed = crossed || !alone.simulation->rows.crossings.empty();
      const World& w = run.world();
      for (std::size_t i = 0; i < w.homes; ++i)
        ASSERT_EQ(w.state(i).position, alone.state(w.id[i]).position) << solver << ' ' << k << ' ' << w.id[i];
    }
    EXPECT_TRUE(crossed) << solver;
  }
}

// The torques of the pairs go into the checkpoint and come back on the ranks that have the bodies then.
TEST(RanksRolling, GoesOnFromACheckpoint) {
  int rank = 0;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  const std::string path = std::filesystem::temp_directory_path() / "unibody_ranks_rolling.h5";
  Experiment run(scene_from_text(heap("accelerated_jacobi")), MPI_COMM_WORLD);
  for (int k = 0; k < 20; ++k) run.step();
  const Simulation& s = *run.simulation;
  write_checkpoint(MPI_COMM_WORLD, path, "0123", 20, 0, 50, s.elements(), s.history);
  std::int64_t pairs = std::ssize(s.history.of<RollingBatch>());
  MPI_Allreduce(MPI_IN_PLACE, &pairs, 1, MPI_INT64_T, MPI_SUM, MPI_COMM_WORLD);
  EXPECT_GT(pairs, 20);
  const auto start = [&](Simulation& to, bool with_torques) {
    const Checkpoint checkpoint(MPI_COMM_WORLD, path, "0123");
    for (std::size_t i = 0; i < to.world.homes; ++i)
      to.world.set_state(i, checkpoint.read_bodies(to.world.id[i], to.world.id[i] + 1)[0].state);
    to.history.contacts() = checkpoint.read_multipliers(to.world);
    to.make_constraints(), to.when.steps_done = 20;
    checkpoint.read_histories(to.elements(), to.history);
    if (!with_torques) to.history.of<RollingBatch>().clear();
  };
  Experiment with(scene_from_text(heap("accelerated_jacobi")), MPI_COMM_WORLD),
      without(scene_from_text(heap("accelerated_jacobi")), MPI_COMM_WORLD);
  with.simulation->move_homes(mixed_homes(with.world(), 1));
  start(*with.simulation, true), start(*without.simulation, false);
  run.step(), with.step(), without.step();
  EXPECT_EQ(with.last.residual, run.last.residual);
  EXPECT_NE(without.last.residual, run.last.residual) << "the torques change nothing";
  const World& w = with.world();
  for (std::size_t i = 0; i < w.homes; ++i) {
    const Slot there = run.world().find(w.id[i]);
    if (there < 0 || !run.world().is_home(there)) continue;
    EXPECT_EQ(w.angular_velocity[i], run.world().angular_velocity[static_cast<std::size_t>(there)]) << w.id[i];
  }
  MPI_Barrier(MPI_COMM_WORLD);
  if (rank == 0) std::filesystem::remove(path);
}

}  // namespace unibody::small_worlds::ranks_rolling_test
