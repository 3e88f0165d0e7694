// The same bits on any number of ranks with all shapes: the first rank runs the scene alone as well.
#include <gtest/gtest.h>

#include "partition/balance.hpp"
#include "partition/ranks.hpp"
#include "report/state_hash.hpp"
#include "small_worlds.hpp"
#include "step/step_parts.hpp"

namespace unibody::small_worlds::ranks_shapes_test {

namespace {

// A bowl of triangles that rocks, grains of all shapes that bounce in it, and a cloth on which some fall.
std::string scene_of(const std::string& solver) {
  return R"(
materials: {m: {friction: 0.4, restitution: 0.3}}
bodies:
  - shape: {mesh: {height_field: {size: [3, 3], cells: [12, 12], hills: 0.6, seed: 2}}}
    motion: kinematic
    angular_velocity: [0.2, 0, 0]
  - pile:
      count: 80
      columns: [4, 4]
      seed: 7
      mix:
        - {shape: {sphere: {radius: 0.06}}}
        - {shape: {box: {size: [0.12, 0.1, 0.08]}}}
        - {shape: {capsule: {radius: 0.04, length: 0.08}}, scale: [0.5, 1.5]}
        - {shape: {cylinder: {radius: 0.05, length: 0.08}}}
        - {shape: {hull: {points: [[0.1, 0, 0], [-0.1, 0, 0], [0, 0.08, 0], [0, -0.08, 0], [0, 0, 0.09]]}}, scale: [0.5, 1]}
        - {shape: {compound: {parts: [{shape: {sphere: {radius: 0.04}}}, {shape: {capsule: {radius: 0.02, length: 0.1}}}]}}}
    density: 1000
    velocity: [0, 0, -3]
    position: [0, 0, 0.7]
cloths:
  - grid: {size: [1, 1], nodes: [9, 9]}
    mass: 1
    thickness: 0.03
    links: {}
    position: [0.3, 0, 0.65]
solver: )" +
         solver;
}

}  // namespace

TEST(RanksShapes, SameBitsOnAnyNumberOfRanks) {
  for (const std::string solver : {"{name: accelerated_jacobi, iterations: 10}", "{name: gauss_seidel, iterations: 6}"}) {
    const std::string text = scene_of(solver);
    Experiment run(scene_from_text(text));  // on all ranks: shapes are numbered as they are read
    const auto alone = of_first_rank([&] {
      std::vector<std::uint64_t> hashes;
      for (int k = 0; k < 3; ++k) run.steps(10), hashes.push_back(state_hash(MPI_COMM_SELF, run.world()));
      EXPECT_TRUE(run.finite());
      return hashes;
    });
    Experiment together(scene_from_text(text), MPI_COMM_WORLD);
    Simulation& s = *together.simulation;
    for (int step = 1; step <= 30; ++step) {
      if (step % 10 == 1) {  // scattered at random
        s.detect();
        s.move_homes(Balance(MPI_COMM_WORLD, std::uint64_t{5} + static_cast<std::uint64_t>(step), true).homes(parts_of(s)));
      }
      together.step();
      if (step % 10 == 0) {
        ASSERT_EQ(alone[static_cast<std::size_t>(step / 10 - 1)], state_hash(MPI_COMM_WORLD, s.world)) << solver << step;
      }
    }
  }
}

}  // namespace unibody::small_worlds::ranks_shapes_test
