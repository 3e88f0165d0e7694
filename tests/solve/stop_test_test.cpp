// A solver stage stops by the natural residual, and the same residual decides whether its step counts as converged.
#include "solve/stop_test.hpp"

#include <gtest/gtest.h>

#include <string>

#include "small_worlds.hpp"

namespace unibody::small_worlds::stop_test_test {

namespace {

const char* const heap = R"(
materials: {m: {friction: 0.5}}
bodies:
  - {shape: {plane: {normal: [0, 0, 1]}}}
  - lattice: {count: 48, columns: [4, 3], spacing: [0.13, 0.13, 0.16], height: 0.2, jitter: 0.01, rotation_jitter: 0.05}
    shape: {box: {size: [0.12, 0.12, 0.15]}}
    mass: 1
)";

const char* const machine = R"(
bodies:
  - {shape: {plane: {normal: [0, 0, 1]}}}
  - {name: arm, shape: {box: {size: [0.4, 0.1, 0.1]}}, mass: 1, position: [0.2, 0, 0.5]}
  - {name: hand, shape: {box: {size: [0.4, 0.1, 0.1]}}, mass: 1, position: [0.6, 0, 0.5]}
joints:
  - {type: hinge, bodies: [arm, world], anchor: [0, 0, 0.5], axis: [0, 1, 0]}
  - {type: hinge, bodies: [hand, arm], anchor: [0.4, 0, 0.5], axis: [0, 1, 0]}
threads:
  - {points: [[0.8, 0, 0.5], [0.8, 0, 0.1]], segments: 4, radius: 0.01, mass: 0.1, pins: [{node: 0, to: hand}]}
)";

}  // namespace

class StopAndVerdict : public testing::TestWithParam<std::tuple<const char*, const char*>> {};

// Where a step took so few iterations that each of its stages must have stopped early, it is converged, and its residual is
// within the tolerance.
TEST_P(StopAndVerdict, WhatStopsEarlyIsConverged) {
  const auto [solver, scene] = GetParam();
  Experiment run(scene_from_text("solver: {name: " + std::string(solver) + ", iterations: 3000}\n" + scene));
  const double tolerance = run.simulation->settings_used().tolerance.value();
  ASSERT_GT(tolerance, 0);
  int early = 0;
  for (int k = 0; k < 100; ++k) {
    const StepReport report = run.step();
    EXPECT_EQ(report.converged, report.residual <= tolerance) << k;
    if (report.iterations >= 1500) continue;  // Gauss-Seidel's velocity stage may take half of them
    ++early;
    EXPECT_TRUE(report.converged) << "step " << k << ", " << report.iterations << " iterations, residual " << report.residual;
  }
  EXPECT_GT(early, 50);
}

INSTANTIATE_TEST_SUITE_P(Scenes, StopAndVerdict,
                         testing::Combine(testing::Values("accelerated_jacobi", "gauss_seidel"), testing::Values(heap, machine)));

}  // namespace unibody::small_worlds::stop_test_test
