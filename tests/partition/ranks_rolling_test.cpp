// Rolling and spinning friction across ranks: a heap of balls and boxes has the bits of one rank.
#include <gtest/gtest.h>

#include "partition/balance.hpp"
#include "small_worlds.hpp"
#include "step/step_parts.hpp"

namespace unibody::small_worlds::ranks_rolling_test {

TEST(RanksRolling, AHeapHasTheBitsOfOneRank) {
  for (const char* solver : {"accelerated_jacobi", "jacobi", "gauss_seidel"}) {
    const std::string text = std::string(R"(
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
    Experiment alone(scene_from_text(text)), run(scene_from_text(text), MPI_COMM_WORLD);
    run.simulation->move_homes(Balance(MPI_COMM_WORLD, 5, false).homes(parts_of(*run.simulation)));
    for (int k = 0; k < 25; ++k) {
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

}  // namespace unibody::small_worlds::ranks_rolling_test
