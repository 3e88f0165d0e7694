// A body that is fixed to the world hangs still, even while the solver presses other bodies, far away, out of the ground.
#include <gtest/gtest.h>

#include "small_worlds.hpp"

namespace unibody::small_worlds::world_joint_test {

// Bricks hit the ground at 12 m/s. The solver has so few iterations that the bricks would end a step below the ground, so that it
// relaxes each of them once more against the ground alone. A brick has three different moments of inertia, and the contacts of
// several bricks stand in one block of the solver.
class JointsToTheWorld : public testing::TestWithParam<const char*> {};

TEST_P(JointsToTheWorld, DoNotFeelWhatSettlesFarAway) {
  const std::string head = "time: {frame: 0.02}\nsolver: " + std::string(GetParam()) +
                           "\nbodies:\n"
                           "  - {name: lamp, shape: {box: {size: [0.2, 0.3, 0.4]}}, mass: 2, position: [50, 0, 5]}\n";
  const std::string joint = "joints:\n  - {type: fixed, bodies: [lamp, world], anchor: [50, 0, 5.2]}\n";
  const std::string bricks =
      "  - {shape: {plane: {normal: [0, 0, 1]}}}\n"
      "  - lattice: {count: 60, columns: [5, 4], spacing: [0.22, 0.17, 0.12], height: 0.1, jitter: 0.01, rotation_jitter: 0.6}\n"
      "    shape: {box: {size: [0.2, 0.15, 0.1]}}\n    mass: 1\n    velocity: [0, 0, -12]\n";
  Experiment alone(scene_from_text(head + joint)), run(scene_from_text(head + bricks + joint));
  for (int k = 0; k < 60; ++k) {
    alone.step(), run.step();
    ASSERT_LT((run.position(0) - alone.position(0)).norm(), 1e-5) << k;
    ASSERT_LT(run.velocity(0).norm(), 0.01) << k;
    ASSERT_LT(run.last.residual_of<JointBatch>(), 1e-3) << k;
  }
}

INSTANTIATE_TEST_SUITE_P(Solvers, JointsToTheWorld,
                         testing::Values("{name: accelerated_jacobi, iterations: 6}",
                                         "{name: accelerated_jacobi, iterations: 12, stages: two}",
                                         "{name: jacobi, iterations: 12, stages: together}",
                                         "{name: gauss_seidel, iterations: 6}"));

}  // namespace unibody::small_worlds::world_joint_test
