// Walls made by turning a profile about an axis: funnels and pipes.
#include <gtest/gtest.h>

#include <cmath>

#include "small_worlds.hpp"

namespace unibody::small_worlds::revolved_test {

namespace {

std::string in_funnel(const std::string& rest, const char* solver, int substeps) {
  return "time: {frame: 0.01, frames: 100, substeps: " + std::to_string(substeps) + "}\nsolver: {name: " + solver +
         "}\nmaterials: {smooth: {friction: 0}}\nbodies:\n" + rest;
}

// A ball of radius r in a cone of n sides: its centre is r / sin(angle) above the apex, where the sides stand at tan(angle) times
// cos(pi / n).
TEST(Revolved, ABallRestsInACone) {
  for (const char* solver : {"accelerated_jacobi", "gauss_seidel"})
    for (const int substeps : {1, 4})
      for (const int n : {7, 64}) {
        SCOPED_TRACE(std::string(solver) + " " + std::to_string(substeps) + " " + std::to_string(n));
        const double angle = std::atan(0.5 * std::cos(M_PI / n)), rest = 0.1 / std::sin(angle);
        Experiment run(
            scene_from_text(in_funnel("  - {shape: {mesh: {revolve: {profile: [[0, 0], [0.5, 1]], sides: " + std::to_string(n) +
                                          "}}}}\n  - {shape: {sphere: {radius: 0.1}}, mass: 2, position: [0.002, 0.001, " +
                                          std::to_string(rest + 0.01) + "]}\n",
                                      solver, substeps)));
        run.seconds(4);
        EXPECT_NEAR(run.position(1).z(), rest, 1e-4);
        EXPECT_LT(run.position(1).head<2>().norm(), 1e-3);
      }
}

// A pipe holds what is in it and keeps out what is not.
TEST(Revolved, APipeHasTwoSides) {
  Experiment run(scene_from_text("gravity: [0, 0, 0]\n" + in_funnel(R"(
  - {shape: {mesh: {revolve: {profile: [[0.5, 0], [0.5, 2]], sides: 32}}}, position: [0, 0, -1]}
  - {shape: {sphere: {radius: 0.1}}, mass: 2, velocity: [3, 1, 0]}
  - {shape: {sphere: {radius: 0.1}}, mass: 2, position: [2, 0, 0.3], velocity: [-3, 0, 0]}
)",
                                                                    "accelerated_jacobi", 1)));
  for (int k = 0; k < 200; ++k) {
    run.step();
    ASSERT_LT(run.position(1).head<2>().norm(), 0.4 + 1e-3) << k;
    ASSERT_GT(run.position(2).head<2>().norm(), 0.6 * std::cos(M_PI / 32) - 1e-3) << k;
  }
}

// A closed profile is a solid ring, touched from outside alone where nothing starts in it.
TEST(Revolved, AClosedProfileIsASolid) {
  Experiment run(scene_from_text(in_funnel(R"(
  - {shape: {mesh: {revolve: {profile: [[0, 0], [1, 0], [1, 0.5], [0, 0.5]], sides: 24}}}}
  - {shape: {box: {size: [0.2, 0.2, 0.2]}}, mass: 2, position: [0.3, 0.2, 0.61]}
)",
                                           "accelerated_jacobi", 1)));
  run.seconds(1);
  EXPECT_NEAR(run.position(1).z(), 0.6, 1e-4);
}

}  // namespace

}  // namespace unibody::small_worlds::revolved_test
