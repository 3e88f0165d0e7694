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

// Balls, boxes and dumb-bells bounce in a box of plates and in a pipe of triangles that turn, at `speed` times 20 m/s.
std::string in_turning_walls(double friction, double speed, const char* solver) {
  const auto velocity = [&](double x, double y, double z) {
    return "mass: 1, velocity: [" + std::to_string(speed * x) + ", " + std::to_string(speed * y) + ", " +
           std::to_string(speed * z) + "]";
  };
  return "materials: {m: {restitution: 1, friction: " + std::to_string(friction) +
         "}}\nsolver: {iterations: 16, name: " + solver +
         R"(}
bodies:
  - {shape: {compound: {parts: [
      {shape: {box: {size: [0.01, 1.2, 1.2]}}, position: [0.505, 0, 0]}, {shape: {box: {size: [0.01, 1.2, 1.2]}}, position: [-0.505, 0, 0]},
      {shape: {box: {size: [1.2, 0.01, 1.2]}}, position: [0, 0.505, 0]}, {shape: {box: {size: [1.2, 0.01, 1.2]}}, position: [0, -0.505, 0]},
      {shape: {box: {size: [1.2, 1.2, 0.01]}}, position: [0, 0, 0.505]}, {shape: {box: {size: [1.2, 1.2, 0.01]}}, position: [0, 0, -0.505]}]}},
     motion: kinematic, angular_velocity: [1, 0, 3]}
  - {shape: {mesh: {revolve: {profile: [[0.5, -2], [0.5, 2]], sides: 32}, sides: both}}, motion: kinematic, position: [3, 0, 0], angular_velocity: [0, 0, 5]}
  - {shape: {sphere: {radius: 0.03}}, points: [[0, 0, 0], [0.1, 0, 0], [0, 0.1, 0], [3, 0, 0], [3, 0.1, 0.4]], )" +
         velocity(20, 7, 3) + R"(}
  - {shape: {box: {size: [0.05, 0.05, 0.05]}}, points: [[0, 0, 0.2], [0.1, 0, 0.2], [0, 0.1, 0.2], [3, 0, 0.2], [3, 0.1, 0.6]], )" +
         velocity(-15, 9, 1) + R"(}
  - {shape: {compound: {parts: [{shape: {sphere: {radius: 0.03}}, position: [0, 0, 0.03]}, {shape: {sphere: {radius: 0.03}}, position: [0, 0, -0.03]}]}},
     points: [[0, 0, -0.2], [0.1, 0, -0.2], [0, 0.1, -0.2], [3, 0, -0.2], [3, 0.1, -0.6]], )" +
         velocity(3, 18, -8) + "}\n";
}

// Bodies that are held back in so many steps, which have the bits of one rank.
std::int64_t held_on_all_ranks(const std::string& scene, int steps) {
  Experiment alone(scene_from_text(scene)), run(scene_from_text(scene), MPI_COMM_WORLD);
  std::int64_t held = 0;
  int differ = 0;
  for (int k = 0; k < steps; ++k) {
    if (k % 6 == 5) run.simulation->move_homes(mixed_homes(run.world(), k));
    alone.step(), run.step();
    held += run.last.held_bodies, differ += run.last.held_bodies != alone.last.held_bodies;
    const World& w = run.world();
    for (std::size_t i = 0; i < w.homes; ++i) differ += w.state(i).position != alone.state(w.id[i]).position;
  }
  EXPECT_EQ(differ, 0);
  return held;
}

// Bodies of equal and of unequal moments of inertia bounce with friction, beside each other.
TEST(RanksRolling, BouncesInTurningWallsHaveTheBitsOfOneRank) {
  for (const char* solver : {"accelerated_jacobi", "gauss_seidel"}) held_on_all_ranks(in_turning_walls(0.1, 1, solver), 60);
}

TEST(RanksRolling, WhatIsHeldBackHasTheBitsOfOneRank) {
  for (const char* solver : {"accelerated_jacobi", "gauss_seidel"})
    EXPECT_GT(held_on_all_ranks(in_turning_walls(0, 3, solver), 60), 0) << solver;
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
