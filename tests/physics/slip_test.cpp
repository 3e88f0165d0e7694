// What friction holds stays where it is: the slip of ten seconds at 1, 4 and 16 steps a frame, with the default settings.
#include <gtest/gtest.h>

#include <string>

#include "small_worlds.hpp"

namespace unibody::small_worlds::slip_test {

namespace {

constexpr double side = 0.1;  // m

// Boxes on each other on a ground that leans against gravity by atan(gravity.x / gravity.z).
std::string leaning(int boxes, const std::string& gravity, const std::string& solver, int substeps) {
  std::string points;
  for (int k = 0; k < boxes; ++k) points += std::string(k > 0 ? ", " : "") + "[0, 0, " + std::to_string(side * (k + 0.5)) + "]";
  return "time: {frame: 0.016, substeps: " + std::to_string(substeps) + "}\ngravity: " + gravity + "\nsolver: {name: " + solver +
         "}\nmaterials: {m: {friction: 0.6}}\nbodies:\n  - {shape: {plane: {normal: [0, 0, 1]}}}\n"
         "  - {shape: {box: {size: [0.1, 0.1, 0.1]}}, mass: 1, points: [" +
         points + "]}\n";
}

// m, of the topmost box from the second second on, in ten seconds.
double slip_of(int boxes, const std::string& gravity, const std::string& solver, int substeps) {
  Experiment run(scene_from_text(leaning(boxes, gravity, solver, substeps)));
  run.seconds(1);
  const Vec3 start = run.position(boxes);
  run.seconds(10);
  return (run.position(boxes) - start).norm();
}

}  // namespace

struct SlipCase {
  const char* solver;
  int substeps;
};

class Slip : public testing::TestWithParam<SlipCase> {};

// tan 27 degrees = 0.52 is less than the coefficient of 0.6: the right slip is 0. The steps are solved: round-off is left.
TEST_P(Slip, ABoxOnASlopeStays) { EXPECT_LT(slip_of(1, "[4.5, 0, -8.7]", GetParam().solver, GetParam().substeps), 1e-6 * side); }

INSTANTIATE_TEST_SUITE_P(Solvers, Slip,
                         testing::Values(SlipCase{"accelerated_jacobi", 1}, SlipCase{"accelerated_jacobi", 4},
                                         SlipCase{"accelerated_jacobi", 16}, SlipCase{"gauss_seidel", 1},
                                         SlipCase{"gauss_seidel", 4}, SlipCase{"gauss_seidel", 16}));

// Fifty iterations do not solve the steps of a stack that leans by 1.8 degrees. What they leave undone falls with the length of
// the step.
TEST(Slip, OfALeaningStackFallsWithTheStep) {
  for (const char* solver : {"accelerated_jacobi", "gauss_seidel"})
    EXPECT_LT(slip_of(5, "[0.3, 0, -9.8]", std::string(solver) + ", iterations: 50", 16), 1e-3 * side) << solver;
}

}  // namespace unibody::small_worlds::slip_test
