// What slides along a cloth or a soft solid goes over its nodes and edges as over one smooth surface.
#include <gtest/gtest.h>

#include <cmath>

#include "report/state_hash.hpp"
#include "small_worlds.hpp"

namespace unibody::small_worlds::sliding_on_surfaces_test {

namespace {

constexpr double g = 9.81;

std::string head(const std::string& solver, int substeps, const std::string& friction) {
  return "time: {substeps: " + std::to_string(substeps) + "}\nsolver: {" + solver + "}\nmaterials: {m: {friction: " + friction +
         "}}\nbodies:\n";
}
std::string body(const std::string& shape, double height, const Vec3& velocity, const std::string& more = "") {
  return "  - {shape: {" + shape + "}, mass: 2, position: [0.013, 0.017, " + std::to_string(height + 0.01) + "], velocity: [" +
         std::to_string(velocity.x()) + ", " + std::to_string(velocity.y()) + ", 0]" + more + "}\n";
}

// A cloth and a block, both held and flat. With their thickness they reach up to z = 0.01, where bodies lie on them.
const std::string cloth =
    "cloths:\n  - {grid: {size: [4, 4], nodes: [21, 21]}, mass: 1, thickness: 0.02, links: {}, "
    "pins: [{within: {min: [-9, -9, -9], max: [9, 9, 9]}}]}\n";
const std::string solid =
    "solids:\n  - {block: {size: [4, 4, 0.2], cells: [20, 20, 1]}, density: 100, position: [0, 0, -0.1], youngs_modulus: 1.0e+5, "
    "poissons_ratio: 0.3, thickness: 0.02, pins: [{within: {min: [-9, -9, -9], max: [9, 9, 9]}}]}\n";

const std::string box = "box: {size: [0.3, 0.3, 0.1]}";

// By how much the velocity of body 0 differs at most from the given one within 0.64 s, over the speed.
double largest_change(Experiment& run, const Vec3& velocity) {
  double largest = 0;
  for (int k = 0, n = static_cast<int>(0.64 / run.h()); k < n; ++k) {
    run.step();
    largest = std::max(largest, (run.velocity(0) - velocity).norm() / velocity.norm());
  }
  return largest;
}

}  // namespace

class SlidingOn : public testing::TestWithParam<std::tuple<const char*, int>> {};

// Without friction the velocity should stay as it is. With 4 steps a frame it does, but for what the iterations leave; with 1
// step a frame a box has been seen to change by 3e-4 of its speed, for which no cause is known.
TEST_P(SlidingOn, WithoutFrictionABoxKeepsItsVelocity) {
  const auto [solver, substeps] = GetParam();
  const double most = substeps == 1 ? 1e-3 : 1e-5;
  for (const std::string& surface : {cloth, solid})
    for (const Vec3& velocity : {Vec3(1, 0, 0), Vec3(0.8, 0.6, 0), Vec3(0.16, 0.12, 0)}) {
      Experiment run(scene_from_text(head("tolerance: 1.0e-8, iterations: 1000, name: " + std::string(solver), substeps, "0") +
                                     body(box, 0.05, velocity) + surface));
      EXPECT_LT(largest_change(run, velocity), most) << velocity.transpose() << '\n' << surface;
    }
}

// Round sides and rims, at the default settings. Where steps end before they have converged, a hundredth may be lost; as long as
// nodes ahead stood in their way it was a third.
TEST_P(SlidingOn, OtherShapesKeepTheirs) {
  const auto [solver, substeps] = GetParam();
  const Vec3 velocity(0.8, 0.6, 0);
  const std::string lying = ", orientation: {axis: [1, 0, 0], angle: 90}";
  const std::string half = "{shape: {box: {size: [0.15, 0.3, 0.1]}}, position: ";
  for (const std::string& text :
       {body("cylinder: {radius: 0.15, length: 0.1}", 0.05, velocity),
        body("capsule: {radius: 0.1, length: 0.2}", 0.1, velocity, lying),
        body("hull: {points: [[0, 0, 0], [0.3, 0, 0], [0, 0.3, 0], [0.3, 0.3, 0], [0, 0, 0.1], [0.3, 0, 0.1], [0, 0.3, 0.1], "
             "[0.3, 0.3, 0.1]]}",
             0.05, velocity),
        body("compound: {parts: [" + half + "[-0.075, 0, 0]}, " + half + "[0.075, 0, 0]}]}", 0.05, velocity),
        body("sphere: {radius: 0.03}", 0.03, velocity)}) {
    Experiment run(scene_from_text(head("name: " + std::string(solver), substeps, "0") + text + cloth));
    EXPECT_LT(largest_change(run, velocity), 0.02) << text;
  }
}

// With friction a box slows down by mu g, whatever it goes over.
TEST_P(SlidingOn, FrictionSlowsABoxByItsCoefficient) {
  const auto [solver, substeps] = GetParam();
  for (const std::string& surface : {cloth, solid}) {
    Experiment run(scene_from_text(head("tolerance: 1.0e-8, iterations: 1000, name: " + std::string(solver), substeps, "0.1") +
                                   body(box, 0.05, Vec3(1, 0, 0)) + surface));
    run.seconds(0.64);
    EXPECT_NEAR(run.velocity(0).x(), 1 - 0.1 * g * 0.64, 1e-3) << surface;
  }
}

// What comes down on a node is held all the same, also where it comes at an angle.
TEST_P(SlidingOn, WhatFallsOnACornerOfTheMeshIsHeld) {
  const auto [solver, substeps] = GetParam();
  for (const Vec3& velocity : {Vec3(0, 0, -3), Vec3(2, 1, -2)}) {
    Scene scene =
        scene_from_text(head("name: " + std::string(solver), substeps, "0.3") +
                        "  - {shape: {box: {size: [0.1, 0.1, 0.1]}}, mass: 2, position: [-0.05, -0.05, 0.3], velocity: [" +
                        std::to_string(velocity.x()) + ", " + std::to_string(velocity.y()) + ", " + std::to_string(velocity.z()) +
                        "], orientation: {axis: [0.6, 0.8, 0], angle: 50}}\n" + cloth);
    Experiment run(std::move(scene));
    run.seconds(1.2);
    EXPECT_GT(run.position(0).z(), 0.045) << velocity.transpose();
    EXPECT_LT(run.position(0).z(), 0.1) << velocity.transpose();
  }
}

INSTANTIATE_TEST_SUITE_P(Solvers, SlidingOn,
                         testing::Combine(testing::Values("accelerated_jacobi", "gauss_seidel"), testing::Values(1, 4)),
                         [](const auto& of) {
                           return std::string(std::get<0>(of.param)) + "_" + std::to_string(std::get<1>(of.param));
                         });

// Whose neighbours lie on which rank says nothing about which nodes lie ahead.
TEST(RanksSlidingOn, StepsHaveTheSameBits) {
  for (const std::string solver : {"accelerated_jacobi", "gauss_seidel"}) {
    const std::string scene =
        head("name: " + solver, 1, "0.05") +
        "  - {lattice: {count: 40, columns: [5, 4], spacing: [0.4, 0.4, 0.3], height: 0.1}, shape: {" + box +
        "}, mass: 2, velocity: [1, 0.3, 0]}\n"
        "  - {lattice: {count: 30, columns: [6, 5], spacing: [0.4, 0.4, 0.3], height: 0.9}, shape: {capsule: "
        "{radius: 0.05, length: 0.1}}, mass: 1, velocity: [-1, 0.3, 0]}\n" +
        cloth;
    Experiment all(scene_from_text(scene), MPI_COMM_WORLD), alone(scene_from_text(scene));
    all.steps(30), alone.steps(30);
    EXPECT_EQ(state_hash(MPI_COMM_WORLD, all.world()), state_hash(MPI_COMM_SELF, alone.world())) << solver;
  }
}

}  // namespace unibody::small_worlds::sliding_on_surfaces_test
