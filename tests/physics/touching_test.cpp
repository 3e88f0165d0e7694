// Which entries touch each other, where `collide` says so: contacts, seams, cloths, and bits on any number of ranks.
#include <gtest/gtest.h>

#include <cmath>

#include "small_worlds.hpp"

namespace unibody::small_worlds::touching_test {

namespace {

std::string ball_at(const std::string& name, double x, double z, const std::string& more = "") {
  return "  - {name: " + name + ", shape: {sphere: {radius: 0.1}}, mass: 1, position: [" + std::to_string(x) + ", 0, " +
         std::to_string(z) + "]" + more + "}\n";
}

const std::string floors =
    "bodies:\n  - {name: sieve, shape: {box: {size: [4, 4, 0.2]}}, motion: fixed, position: [0, 0, 0.9]}\n"
    "  - {name: floor, shape: {plane: {normal: [0, 0, 1]}}}\n";

class TouchingOf : public testing::TestWithParam<const char*> {
 protected:
  static std::string settings() { return std::string("solver: {name: ") + GetParam() + "}\n"; }
};

}  // namespace

// A ball that may touch the floor alone falls through the sieve and through others, which lie on the sieve.
TEST_P(TouchingOf, WhatMayTouchTheFloorAloneFallsThroughAllElse) {
  Experiment run(scene_from_text(floors + ball_at("fine", 0, 1.4, ", collide: {with: [floor]}") + ball_at("coarse", 0, 1.1) +
                                 ball_at("coarse", 1, 1.1) + settings()));
  run.seconds(1.5);
  EXPECT_NEAR(run.position(2).z(), 0.1, 1e-4);
  EXPECT_NEAR(run.position(3).z(), 1.1, 1e-4);
  EXPECT_NEAR(run.position(4).z(), 1.1, 1e-4);
}

// The exclusion holds whichever of the two says it, and of a fast ball, which is swept. Bodies that exclude their own entry pass
// through each other.
TEST_P(TouchingOf, WithoutExcludesBothWays) {
  Experiment run(scene_from_text(
      "gravity: [0, 0, 0]\nbodies:\n" + ball_at("one", 0, 0, ", velocity: [30, 0, 0], collide: {without: [two]}") +
      ball_at("two", 1, 0) + ball_at("three", 3, 0, ", velocity: [-30, 0, 0]") +
      ball_at("four", 6, 0, ", velocity: [-1, 0, 0], collide: {without: [four]}") + ball_at("four", 5, 0) + settings()));
  run.seconds(0.05);
  EXPECT_LT(run.velocity(0).x(), 1);  // it has met three, behind two
  EXPECT_GT(run.position(0).x(), 1);
  run.seconds(2);
  EXPECT_EQ(run.velocity(3), Vec3(-1, 0, 0));
  EXPECT_EQ(run.velocity(4), Vec3(0, 0, 0));
}

// A ball over the seam of two tiles of which it may touch the first alone: it meets that one's edge, and is not carried on along
// the other's plane.
TEST_P(TouchingOf, ATileThatIsNotTouchedHidesNoEdge) {
  const auto tile = [](const std::string& name, double x) {
    return "  - {name: " + name + ", shape: {box: {size: [1, 1, 0.2]}}, motion: fixed, position: [" + std::to_string(x) +
           ", 0, -0.1]}\n";
  };
  Experiment run(scene_from_text("materials: {ice: {friction: 0}}\nbodies:\n" + tile("first", 0) + tile("second", 1) +
                                 ball_at("ball", 0.3, 0.1, ", velocity: [1, 0, 0], collide: {without: [second]}") + settings()));
  run.seconds(0.6);
  EXPECT_LT(run.position(2).z(), -0.1);
}

// A cloth that is not touched: the ball goes through its faces as if it were not there. One that is catches it.
TEST_P(TouchingOf, ABallGoesThroughAClothThatItMayNotTouch) {
  for (const bool touches : {false, true}) {
    Experiment run(scene_from_text(
        "bodies:\n" + ball_at("ball", 0.03, 0.3, touches ? "" : ", collide: {without: [sheet]}") +
        "cloths:\n  - {name: sheet, grid: {size: [1, 1], nodes: [11, 11]}, position: [-0.5, -0.5, 0], mass: "
        "0.5, thickness: 0.01, links: {}, pins: [{node: [0, 0]}, {node: [10, 0]}, {node: [0, 10]}, {node: [10, 10]}]}\n" +
        settings()));
    run.seconds(0.5);
    const double fallen = 0.3 - run.position(0).z();
    if (touches) {
      EXPECT_LT(fallen, 0.6);
    } else {
      EXPECT_NEAR(fallen, 0.5 * 9.81 * 0.25, 0.05);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Solvers, TouchingOf, testing::Values("accelerated_jacobi", "gauss_seidel"),
                         [](const auto& each) { return std::string(each.param); });

TEST(RanksTouching, StepsHaveTheSameBits) {
  const std::string scene = floors +
                            "  - {name: fine, lattice: {count: 60, columns: [5, 3], spacing: [0.3, 0.3, 0.3], height: 1.3, "
                            "jitter: 0.02}, shape: {sphere: "
                            "{radius: 0.08}}, mass: 1, collide: {with: [floor, fine]}}\n"
                            "  - {name: coarse, lattice: {count: 60, columns: [5, 3], spacing: [0.3, 0.3, 0.3], height: 1.35, "
                            "jitter: 0.02}, shape: {box: "
                            "{size: [0.1, 0.15, 0.2]}}, mass: 1}\n";
  Experiment alone(scene_from_text(scene)), together(scene_from_text(scene), MPI_COMM_WORLD);
  alone.steps(60), together.steps(60);
  World& world = together.world();
  for (std::size_t i = 0; i < world.homes; ++i) EXPECT_EQ(world.position[i], alone.position(world.id[i])) << world.id[i];
  double lowest = 9;
  for (Id id = 62; id < 122; ++id) lowest = std::min(lowest, alone.position(id).z());
  EXPECT_GT(lowest, 1);  // the coarse ones lie on the sieve
  EXPECT_LT(alone.position(2).z(), 0.8);
}

}  // namespace unibody::small_worlds::touching_test
