// Momentum for Gauss-Seidel: less error after as many sweeps, the same solution, and no more sweeps where they are fast anyway.
#include "solve/sweep_momentum.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "scene/scene.hpp"
#include "small_worlds.hpp"

namespace unibody::small_worlds::sweep_momentum_test {

namespace {

constexpr int balls = 20;
constexpr double gravity = 9.81;  // m/s^2

// Balls of 1 kg stand at rest, one on top of the other. Each step is one position stage, which starts from multipliers of zero.
std::string column(const char* acceleration, int iterations) {
  return "gravity: [0, 0, -9.81]\nsolver: {name: gauss_seidel, stages: position, warm_start: 0, tolerance: 0, acceleration: " +
         std::string(acceleration) + ", iterations: " + std::to_string(iterations) +
         "}\nbodies:\n  - {shape: {plane: {normal: [0, 0, 1]}}}\n"
         "  - lattice: {count: 20, columns: [1, 1], spacing: [0.1, 0.1, 0.1], height: 0.05, jitter: 0}\n"
         "    shape: {sphere: {radius: 0.05}}\n    mass: 1\n";
}

// The largest error of the contacts' forces after a first step, over the weight of the column. Ball k, which is body k, bears
// those above it, and all but the last are borne by a ball.
double error_of_forces(const char* acceleration, int iterations) {
  Experiment run(scene_from_text(column(acceleration, iterations)));
  run.step();
  double error = std::abs(run.normal_force(0, 1) / (balls * gravity) - 1);
  for (int k = 1; k < balls; ++k)
    error = std::max(error, std::abs(run.normal_force(k, k + 1) / (balls * gravity) - static_cast<double>(balls - k) / balls));
  return error;
}

}  // namespace

TEST(SweepMomentum, LeavesLessErrorInTheForcesOfAColumn) {
  const double plain = error_of_forces("none", 100), accelerated = error_of_forces("auto", 100);
  EXPECT_GT(plain, 0.1) << "too easy to tell them apart";
  EXPECT_LT(accelerated, plain / 5);
}

TEST(SweepMomentum, LeadsToTheSameForces) { EXPECT_LT(error_of_forces("auto", 1000), 1e-9); }

// Residuals are zero at the solution alone: of a chain of 100 joints with a ball of 1,000 times the mass of its links, and of a
// cloth that hangs by two corners.
TEST(SweepMomentum, LeavesASmallerResidualInChainsAndCloths) {
  for (const std::string scene : {"chain_heavy_ball", "cloth_hanging"}) {
    const auto residual = [&](const char* acceleration) {
      Experiment run(read_scene(UNIBODY_SOURCE_DIR "/scenes/" + scene + ".yaml",
                                {{"solver.name", "gauss_seidel"}, {"solver.acceleration", acceleration}}));
      double sum = 0;
      for (int k = 0; k < 60; ++k) {
        const double left = run.step().residual;
        if (k >= 20) sum += left;  // once it is under way
      }
      return sum;
    };
    EXPECT_LT(residual("auto"), residual("none") / 2) << scene;
  }
}

// The sweeps of a soft block contract fast: Nesterov's share, which goes to 1, would need twice as many.
TEST(SweepMomentum, TakesNoMoreSweepsWhereTheyAreFast) {
  const auto iterations = [](const char* acceleration) {
    Experiment run(read_scene(UNIBODY_SOURCE_DIR "/scenes/soft_block_on_floor.yaml",
                              {{"solver.name", "gauss_seidel"}, {"solver.acceleration", acceleration}}));
    int sum = 0;
    for (int k = 0; k < 10; ++k) {
      const StepReport report = run.step();
      EXPECT_TRUE(report.converged) << acceleration << ", step " << k;
      sum += report.iterations;
    }
    return sum;
  };
  EXPECT_LE(iterations("nesterov"), 1.1 * iterations("none"));
}

}  // namespace unibody::small_worlds::sweep_momentum_test
