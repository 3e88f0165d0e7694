// Bodies that others set moving within a step, at default settings: they push on what lies in their way, and keep out of it.
#include <gtest/gtest.h>

#include <cmath>

#include "small_worlds.hpp"

namespace unibody::small_worlds::struck_test {

class Struck : public testing::TestWithParam<std::tuple<const char*, int>> {
 protected:
  std::string head() const {
    const auto [solver, substeps] = GetParam();
    return "time: {frame: 0.016, substeps: " + std::to_string(substeps) + "}\nsolver: {name: " + std::string(solver) +
           ", iterations: 400}\ngravity: [0, 0, 0]\nmaterials: {m: {friction: 0}}\nbodies:\n";
  }
};

// A ball of 10 kg runs into five of 10 g, one radius apart, at five of their radii a step: all go on together at M v / (M + 5 m),
// in the order in which they were. (What the gaps leave of it: those further on are pushed ahead by what recovers from overlap.)
TEST_P(Struck, ARowKeepsItsOrder) {
  for (const char* small : {"sphere: {radius: 0.01}", "box: {size: [0.02, 0.02, 0.02]}"}) {
    Experiment run(scene_from_text(head() +
                                   "  - {shape: {sphere: {radius: 0.1}}, mass: 10, position: [-0.13, 0, 0], velocity: [3, "
                                   "0, 0]}\n  - {shape: {" +
                                   small +
                                   "}, mass: 0.01, lattice: {count: 5, columns: [5, 1], spacing: [0.03, 0.03, 0.03]}, "
                                   "position: [0.07, 0, 0]}\n"));
    double deepest = 0;
    const int steps = 12 * std::get<1>(GetParam());
    for (int k = 0; k < steps; ++k) {
      run.step();
      for (std::size_t i = 1; i + 1 < 6; ++i) deepest = std::max(deepest, 0.02 - (run.position(i + 1).x() - run.position(i).x()));
      deepest = std::max(deepest, 0.11 - (run.position(1).x() - run.position(0).x()));
    }
    EXPECT_LT(deepest, 0.25 * 0.01) << small;
    const double together = 3 * 10 / 10.05;
    EXPECT_NEAR(run.velocity(0).x(), together, 2e-3) << small;
    for (std::size_t i = 1; i < 6; ++i) EXPECT_NEAR(run.velocity(i).x(), together, 0.12 * together) << small << ' ' << i;
  }
}

// A wall that none of them was near enough to at the start of the step holds the last of a pair: all stop there. (Of lighter
// balls Gauss-Seidel would need thousands of iterations.)
TEST_P(Struck, AWallBehindHoldsThem) {
  for (const char* wall : {"box: {size: [0.2, 1, 1]}", "plane: {normal: [-1, 0, 0]}"}) {
    const std::string place = wall[0] == 'b' ? "0.175" : "0.075";
    Experiment run(scene_from_text(head() +
                                   "  - {shape: {sphere: {radius: 0.1}}, mass: 0.1, position: [-0.13, 0, 0], velocity: [3, "
                                   "0, 0]}\n  - {shape: {sphere: {radius: 0.01}}, mass: 0.01, position: [0.01, 0, 0]}\n  "
                                   "- {shape: {sphere: {radius: 0.01}}, mass: 0.01, position: [0.04, 0, 0]}\n  - {shape: {" +
                                   std::string(wall) + "}, motion: fixed, position: [" + place + ", 0, 0]}\n"));
    double furthest = -1;
    for (int k = 0; k < 12 * std::get<1>(GetParam()); ++k) {
      run.step();
      furthest = std::max(furthest, run.position(2).x());
    }
    EXPECT_LT(furthest, 0.075 - 0.01 + 0.25 * 0.01) << wall;
    EXPECT_LT(run.velocity(0).x(), 0.05) << wall;
    EXPECT_LT(run.position(0).x(), run.position(1).x()) << wall;
    EXPECT_LT(run.position(1).x(), run.position(2).x()) << wall;
  }
}

INSTANTIATE_TEST_SUITE_P(All, Struck,
                         testing::Combine(testing::Values("accelerated_jacobi", "gauss_seidel"), testing::Values(1, 4)));

}  // namespace unibody::small_worlds::struck_test
