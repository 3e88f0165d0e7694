// A stack of boxes stays upright for ten seconds, although the default iterations do not solve its steps in full.
#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "small_worlds.hpp"

namespace unibody::small_worlds::stack_stands_test {

namespace {

constexpr double side = 0.1;  // m
constexpr int boxes = 5;

std::string stack(const char* solver, int substeps) {
  std::string points;
  for (int k = 0; k < boxes; ++k) points += std::string(k > 0 ? ", " : "") + "[0, 0, " + std::to_string(side * (k + 0.5)) + "]";
  return "time: {frame: 0.016, substeps: " + std::to_string(substeps) + "}\nsolver: {iterations: 50, name: " + solver +
         "}\nmaterials: {wood: {friction: 0.6}}\nbodies:\n"
         "  - {shape: {plane: {normal: [0, 0, 1]}}, material: wood}\n"
         "  - {shape: {box: {size: [0.1, 0.1, 0.1]}}, mass: 1, material: wood, points: [" +
         points + "]}\n";
}

}  // namespace

struct StackCase {
  const char* solver;
  int substeps;
};

class StackOfBoxes : public testing::TestWithParam<StackCase> {};

// At rest each box stays where it is put: 0.05 m, 0.15 m, ... above the ground and right above the others. Its bounds are a
// fiftieth of a side across and a two-hundredth in height.
TEST_P(StackOfBoxes, StandsForTenSeconds) {
  const auto [solver, substeps] = GetParam();
  Experiment run(scene_from_text(stack(solver, substeps)));
  for (int k = 0; k < 625 * substeps; ++k) run.step();
  for (int k = 0; k < boxes; ++k) {
    const Vec3 place = run.position(k + 1);
    EXPECT_LT(place.head<2>().norm(), 0.02 * side) << "box " << k;
    EXPECT_NEAR(place.z(), side * (k + 0.5), 0.005 * side) << "box " << k;
  }
}

INSTANTIATE_TEST_SUITE_P(Solvers, StackOfBoxes,
                         testing::Values(StackCase{"accelerated_jacobi", 1}, StackCase{"accelerated_jacobi", 4},
                                         StackCase{"gauss_seidel", 1}, StackCase{"gauss_seidel", 4}));

}  // namespace unibody::small_worlds::stack_stands_test
