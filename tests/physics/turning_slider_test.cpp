// What slides on an arm that turns: the rate of a slider is that at which its offset changes, in whatever frame that is kept.
#include <gtest/gtest.h>

#include <cmath>

#include "small_worlds.hpp"

namespace unibody::small_worlds::turning_slider_test {

namespace {

std::string number(double x) { return std::to_string(x); }

constexpr double turn = 3, start = 0.5;

// A bead of 1 kg on a slider along an arm that turns, 0.5 m from the axis.
Scene bead(const std::string& solver, int substeps, const std::string& of_slider) {
  return scene_from_text(
      "gravity: [0, 0, 0]\ntime: {substeps: " + std::to_string(substeps) + "}\nsolver: {name: " + solver +
      "}\nbodies:\n"
      "  - {name: arm, shape: {box: {size: [0.2, 0.2, 0.2]}}, motion: kinematic, angular_velocity: [0, 0, " +
      number(turn) +
      "]}\n"
      "  - {name: bead, shape: {box: {size: [0.1, 0.1, 0.1]}}, mass: 1, position: [0.5, 0, 0], velocity: [0, " +
      number(turn * start) + ", 0], angular_velocity: [0, 0, " + number(turn) +
      "]}\n"
      "joints:\n  - {type: slider, bodies: [arm, bead], axis: [1, 0, 0], anchor: [0.5, 0, 0], " +
      of_slider + "}\n");
}

}  // namespace

class TurningSlider : public testing::TestWithParam<std::tuple<const char*, int>> {};

// A spring with a damper: at rest on the arm k (r - r_0) = m w^2 r, whatever the damper.
TEST_P(TurningSlider, RestsWhereItsSpringHoldsIt) {
  const auto [solver, substeps] = GetParam();
  const double stiffness = 400, right = start * stiffness / (stiffness - turn * turn);
  for (const double damping : {10, 40, 160}) {
    Experiment run(bead(solver, substeps, "spring: {stiffness: 400, damping: " + number(damping) + "}"));
    run.seconds(8);
    EXPECT_NEAR(run.position(1).norm(), right, 0.01 * (right - start)) << damping;
  }
}

// Friction holds it where m w^2 r is less than it can give: with a reserve of a tenth it moves in 8 s by less than a thousandth
// of its size.
TEST_P(TurningSlider, StaysWhereItsFrictionHoldsIt) {
  const auto [solver, substeps] = GetParam();
  Experiment run(bead(solver, substeps, "friction: " + number(1.1 * turn * turn * start)));
  run.seconds(8);
  EXPECT_NEAR(run.position(1).norm(), start, 1e-4);
}

INSTANTIATE_TEST_SUITE_P(Solvers, TurningSlider,
                         testing::Combine(testing::Values("accelerated_jacobi", "gauss_seidel"), testing::Values(1, 4)));

}  // namespace unibody::small_worlds::turning_slider_test
