// A thread's links and the pin that holds a body by its last node balance each other from step to step: a step that starts from
// the old force of the one without that of the other throws the body up.
#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "small_worlds.hpp"

namespace unibody::small_worlds::balanced_pairs_test {

namespace {

std::string ball_on_thread(double mass, int substeps, const std::string& solver) {
  return "time: {frame: 0.016, substeps: " + std::to_string(substeps) + "}\nsolver: {" + solver +
         "}\nbodies:\n"
         "  - {name: ball, shape: {sphere: {radius: 0.05}}, mass: " +
         std::to_string(mass) +
         ", position: [0, 0, -1.05]}\n"
         "threads:\n"
         "  - points: [[0, 0, 0], [0, 0, -1]]\n"
         "    segments: 10\n"
         "    radius: 0.01\n"
         "    mass: 0.01\n"
         "    pins: [{node: 0}, {node: 10, to: ball}]\n";
}

}  // namespace

class BalancedPairs : public testing::TestWithParam<std::tuple<const char*, int, int>> {};

// The ball is at rest and hangs straight down, at 1 to 1000 times the mass of its thread: it has its energy at the start and no
// more, is never above its place, and moves to no side. (How far it sinks is what the iterations leave undone.)
TEST_P(BalancedPairs, AHangingBallIsNotThrownUp) {
  const auto [solver, iterations, substeps] = GetParam();
  for (const double ratio : {1.0, 10.0, 30.0, 100.0, 1000.0}) {
    const std::string settings = "name: " + std::string(solver) + ", iterations: " + std::to_string(iterations);
    Experiment run(scene_from_text(ball_on_thread(0.01 * ratio, substeps, settings)));
    run.simulation->detect();
    // Each of ten links and the pin may be left short by the tolerance.
    const double start = run.energy(), lift = 11 * run.simulation->settings_used().tolerance.value();
    double most = start, highest = -1.05, aside = 0;
    for (int k = 0; k < 200 * substeps; ++k) {
      run.step();
      most = std::max(most, run.energy());
      const Vec3 place = run.position(0);
      highest = std::max(highest, place.z()), aside = std::max({aside, std::abs(place.x()), std::abs(place.y())});
    }
    EXPECT_LE(most, start + 0.01 * (ratio + 1) * 9.81 * lift) << ratio;
    EXPECT_LE(highest, -1.05 + lift) << ratio;
    EXPECT_LT(aside, 1e-9) << ratio;
  }
}

// With iterations enough for the mass it hangs where it is, and the pin bears its weight.
TEST(BalancedPair, ThePinBearsTheBall) {
  for (const int substeps : {1, 4}) {
    Experiment run(scene_from_text(ball_on_thread(1, substeps, "iterations: 20000")));
    run.steps(10 * substeps);
    EXPECT_TRUE(run.last.converged);
    EXPECT_NEAR(run.position(0).z(), -1.05, 1e-4);
    const auto& pins = run.simulation->history.of<AttachmentBatch>();
    ASSERT_EQ(pins.size(), 1u);
    EXPECT_NEAR(pins[0][2] / run.h(), 9.81, 0.02);
    EXPECT_NEAR(pins[0][0], 0, 1e-9);
  }
}

// A soft, damped thread at rest: each link bears all that hangs below it, in steps that say that they have converged.
TEST(BalancedPair, LinksBearWhatHangsBelowThem) {
  Experiment run(scene_from_text(R"(
solver: {iterations: 1000}
bodies:
  - {name: ball, shape: {sphere: {radius: 0.05}}, mass: 1, position: [0, 0, -1.05]}
threads:
  - points: [[0, 0, 0], [0, 0, -1]]
    segments: 10
    radius: 0.01
    mass: 0.01
    stretch: {stiffness: 2000, damping: 0.02}
    pins: [{node: 0}, {node: 10, to: ball}]
)"));
  run.steps(200);
  EXPECT_TRUE(run.last.converged);
  const auto& links = run.simulation->history.of<ConstraintBatch<Distance>>();
  ASSERT_EQ(links.size(), 10u);
  for (std::size_t k = 0; k < 10; ++k) {
    const double below = 1 + 0.001 * (9.5 - static_cast<double>(k));  // kg: the last node has half of a link's mass
    EXPECT_NEAR(-links[k][0] / run.h(), 9.81 * below, 1e-3) << k;
  }
}

INSTANTIATE_TEST_SUITE_P(Solvers, BalancedPairs,
                         testing::Combine(testing::Values("accelerated_jacobi", "gauss_seidel"), testing::Values(50, 400),
                                          testing::Values(1, 4)));

}  // namespace unibody::small_worlds::balanced_pairs_test
