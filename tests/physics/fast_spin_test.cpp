// Bodies that turn far in a step: free ones keep their phase, and jointed ones their joints.
#include <gtest/gtest.h>

#include <cmath>

#include "small_worlds.hpp"

namespace unibody::small_worlds::fast_spin_test {

namespace {

Quat turned_after(const std::string& shape, const std::string& spin, int substeps, double t) {
  Experiment run(scene_from_text("time: {substeps: " + std::to_string(substeps) +
                                 "}\ngravity: [0, 0, 0]\nbodies:\n  - {shape: {" + shape +
                                 "}, mass: 1, angular_velocity: " + spin + "}\n"));
  run.seconds(t);
  return run.state(0).orientation;
}

}  // namespace

// A ball turns by w t. A brick is compared with itself in steps of a 256th.
TEST(FastSpin, FreeBodiesKeepTheirPhase) {
  const double t = 41 * 0.016;
  for (const double w : {10., 30., 63., 150.}) {
    const Quat ball = turned_after("sphere: {radius: 0.1}", "[0, 0, " + std::to_string(w) + "]", 1, t);
    EXPECT_LT(ball.angularDistance(Quat(Eigen::AngleAxisd(w * t, Vec3::UnitZ()))), w * 0.016 > 0.2 ? 1e-9 : 0.02) << w;
    const std::string spin =
        "[" + std::to_string(0.5 * w) + ", " + std::to_string(0.1 * w) + ", " + std::to_string(0.86 * w) + "]";
    const std::string brick = "box: {size: [0.3, 0.2, 0.1]}";
    EXPECT_LT(turned_after(brick, spin, 1, t).angularDistance(turned_after(brick, spin, 256, t)), 4e-3 * w * t) << w;
  }
}

// A top on an arm of 10 cm at 200 rad/s and 16 ms, which is 3.2 rad a step.
TEST(FastSpin, JointsStayClosed) {
  for (const char* solver : {"accelerated_jacobi", "gauss_seidel"})
    for (const int substeps : {1, 4}) {
      Experiment run(
          scene_from_text("time: {substeps: " + std::to_string(substeps) + "}\nsolver: {name: " + solver +
                          "}\nbodies:\n  - {name: top, shape: {cylinder: {radius: 0.05, length: 0.02}}, mass: 1, position: "
                          "[0.0866, 0, 0.05], orientation: {axis: [0, 1, 0], angle: 60}, angular_velocity: [173.2, 0, "
                          "100]}\njoints:\n  - {type: ball, bodies: [top, world], anchor: [0, 0, 0]}\n"));
      const double arm = run.position(0).norm(), before = run.energy();
      const int steps = static_cast<int>(2 / run.h());
      for (int k = 0; k < steps; ++k) {
        run.step();
        ASSERT_NEAR(run.position(0).norm(), arm, 1e-4) << solver << ' ' << k;
      }
      EXPECT_NEAR(run.energy(), before, 2e-3 * before) << solver;
      EXPECT_NEAR(run.simulation->time(), steps * run.h(), 1e-12);
    }
}

// What is beyond the most parts of a step is not called converged.
TEST(FastSpin, WhatCannotBeDividedIsSaid) {
  Experiment run(
      scene_from_text("bodies:\n  - {name: top, shape: {sphere: {radius: 0.1}}, mass: 1, position: [0.3, 0, 0], "
                      "angular_velocity: [0, 0, 6000]}\njoints:\n  - {type: ball, bodies: [top, world], anchor: [0, 0, "
                      "0]}\n"));
  run.step();
  EXPECT_TRUE(!run.last.converged || run.position(0).norm() < 0.3 * 1.001);
}

// A wheel on its axle may turn at any speed: nothing is divided for it.
TEST(FastSpin, WheelsAreFree) {
  Experiment run(
      scene_from_text("gravity: [0, 0, 0]\nbodies:\n  - {name: wheel, shape: {cylinder: {radius: 0.3, length: 0.1}}, mass: "
                      "1, angular_velocity: [0, 0, 300]}\njoints:\n  - {type: hinge, bodies: [wheel, world], anchor: [0, 0, "
                      "0], axis: [0, 0, 1]}\n"));
  run.steps(10);
  EXPECT_TRUE(run.last.converged);
  EXPECT_LE(run.last.iterations, 50);
  EXPECT_NEAR(run.state(0).angular_velocity.z(), 300, 1e-6);
}

}  // namespace unibody::small_worlds::fast_spin_test
