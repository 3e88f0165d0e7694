// Bodies that slide or roll over flush solids do not feel the seams: their speed stays what it is on one surface.
#include <gtest/gtest.h>

#include <cmath>

#include "small_worlds.hpp"

namespace unibody::small_worlds::seams_test {

namespace {

struct Floor {
  const char* name;
  std::string bodies;  // its top at z = 0, its seam at x = 0.5; of the text's first bodies
  int count;
};

const std::string hull =
    "{shape: {hull: {points: [[0, -1, 0], [1, -1, 0], [0, 1, 0], [1, 1, 0], [0.2, -1, -1], [0.8, -1, -1], [0.2, 1, -1], "
    "[0.8, 1, -1]]}}, motion: fixed, position: ";

const Floor floors[] = {
    {"two boxes", "  - {shape: {box: {size: [1, 1, 1]}}, motion: fixed, points: [[0, 0, -0.5], [1, 0, -0.5]]}\n", 2},
    {"boxes 3 mm apart",
     "  - {shape: {box: {size: [1, 1, 1]}}, motion: fixed, points: [[-0.0015, 0, -0.5], [1.0015, 0, -0.5]]}\n", 2},
    {"parts of a compound",
     "  - {shape: {compound: {parts: [{shape: {box: {size: [1, 1, 1]}}, position: [0, 0, -0.5]}, {shape: {box: {size: [1, 1, "
     "1]}}, position: [1, 0, -0.5]}]}}, motion: fixed, position: [0.5, 0, -0.5]}\n",
     1},
    {"four tiles",
     "  - {shape: {box: {size: [1, 1, 1]}}, motion: fixed, points: [[0, 0.55, -0.5], [1, 0.55, -0.5], [0, -0.45, -0.5], [1, "
     "-0.45, -0.5]]}\n",
     4},
    {"a plane and a box",
     "  - {shape: {plane: {normal: [0, 0, 1]}}}\n  - {shape: {box: {size: [1, 1, 1]}}, motion: fixed, position: [1, 0, -0.5]}\n",
     2},
    {"a field and a box",
     "  - {shape: {mesh: {height_field: {size: [2, 2], cells: [2, 2], heights: [0, 0, 0, 0, 0, 0, 0, 0, 0]}}}, position: [-0.5, "
     "0, "
     "0]}\n  - {shape: {box: {size: [1, 1, 1]}}, motion: fixed, position: [1, 0, -0.5]}\n",
     2},
    {"a box and a field",
     "  - {shape: {box: {size: [1, 1, 1]}}, motion: fixed, position: [0, 0, -0.5]}\n  - {shape: {mesh: {height_field: {size: [2, "
     "2], "
     "cells: [2, 2], heights: [0, 0, 0, 0, 0, 0, 0, 0, 0]}}}, position: [1.5, 0, 0]}\n",
     2},
};

struct Slider {
  const char* shape;
  double height;  // m, of its centre
};
const Slider sliders[] = {
    {"box: {size: [0.4, 0.4, 0.4]}", 0.2}, {"cylinder: {radius: 0.2, length: 0.2}", 0.1}, {"sphere: {radius: 0.1}", 0.1}};

std::string number(double x) { return std::to_string(x); }

Experiment sliding(const std::string& floor, const Slider& slider, double speed, double friction, const std::string& more,
                   const std::string& solver, int substeps) {
  return Experiment(scene_from_text("time: {substeps: " + number(substeps).substr(0, 1) + "}\nmaterials: {m: {friction: " +
                                    number(friction) + "}}\nsolver: {name: " + solver + "}\nbodies:\n" + floor + "  - {shape: {" +
                                    slider.shape + "}, mass: 1, position: [" + number(0.25 - 0.02 * speed) + ", 0, " +
                                    number(slider.height) + "], velocity: [" + number(speed) + ", 0, 0]" + more + "}\n"));
}

}  // namespace

class Seams : public testing::TestWithParam<std::tuple<const char*, int>> {};

// Until the centre is past the seam.
TEST_P(Seams, WithoutFrictionNothingHappens) {
  const auto [solver, substeps] = GetParam();
  for (const Floor& floor : floors)
    for (const Slider& slider : sliders)
      for (const double speed : {0.1, 2.0, 5.0}) {
        if (std::string(floor.name) == "boxes 3 mm apart" && slider.shape[0] != 'b') continue;  // a ball dips into the gap
        Experiment run = sliding(floor.bodies, slider, speed, 0, "", solver, substeps);
        const Id id = floor.count;
        const double start = run.position(id).x();
        int steps = 0;
        for (; run.position(id).x() < 0.6 && steps < 4000; ++steps) {
          run.step();
          const double share = floor.count == 4 ? 1e-5 : 1e-6;  // on four tiles at once the solve leaves more undone
          ASSERT_NEAR(run.velocity(id).x(), speed, share * speed)
              << floor.name << ", " << slider.shape << ", " << speed << " m/s";
          ASSERT_NEAR(run.position(id).z(), slider.height, 1e-4) << floor.name << ", " << slider.shape << ", " << speed << " m/s";
        }
        EXPECT_NEAR(run.position(id).x(), start + speed * steps * run.h(), 1e-5) << floor.name << ", " << slider.shape;
      }
}

TEST_P(Seams, ABallRollsOn) {
  const auto [solver, substeps] = GetParam();
  for (const Floor& floor : floors) {
    if (std::string(floor.name) == "boxes 3 mm apart") continue;  // it dips into the gap
    Experiment run = sliding(floor.bodies, sliders[2], 5, 0.5, ", angular_velocity: [0, 50, 0]", solver, substeps);
    while (run.position(floor.count).x() < 0.8) {
      run.step();
      ASSERT_NEAR(run.velocity(floor.count).x(), 5, 5e-6) << floor.name;
      ASSERT_NEAR(run.position(floor.count).z(), 0.1, 1e-6) << floor.name;
    }
  }
}

// v0^2 / (2 mu g), less v0 h / 2 of the steps, straight on: over eleven tiles and beside a seam along the way.
TEST_P(Seams, FrictionStopsABoxWhereItDoesOnOneSurface) {
  const auto [solver, substeps] = GetParam();
  const std::string tiles =
      "  - {shape: {box: {size: [1, 1, 1]}}, motion: fixed, lattice: {count: 33, columns: [11, 3], spacing: [1, 1, 1]}, "
      "position: [5, "
      "0, -0.5]}\n";
  Experiment run(scene_from_text("time: {substeps: " + number(substeps).substr(0, 1) +
                                 "}\nmaterials: {m: {friction: 0.3}}\nsolver: {name: " + solver + "}\nbodies:\n" + tiles +
                                 "  - {shape: {box: {size: [0.4, 0.4, 0.4]}}, mass: 1, position: [0.1, 0.13, 0.2], velocity: [5, "
                                 "0.7, 0]}\n"));
  const double speed = std::hypot(5, 0.7);
  run.seconds(2.5);
  const Vec3 way = run.position(33) - Vec3(0.1, 0.13, 0.2);
  EXPECT_NEAR(way.norm(), speed * speed / (2 * 0.3 * 9.81) - 0.5 * speed * run.h(), 2e-3);
  EXPECT_NEAR(way.y() / way.x(), 0.14, 5e-4);
}

// A wall of bricks beside a box that falls along it; and a belt of plates that moves under a box.
TEST_P(Seams, OfWallsAndOfWhatMoves) {
  const auto [solver, substeps] = GetParam();
  const std::string head = "time: {substeps: " + number(substeps).substr(0, 1) +
                           "}\nmaterials: {m: {friction: 0}}\nsolver: {name: " + solver + "}\nbodies:\n";
  Experiment fall(
      scene_from_text(head + "  - {shape: {box: {size: [1, 1, 1]}}, motion: fixed, points: [[0, 0, -0.5], [0, 0, -1.5], [0, 0, "
                             "-2.5]]}\n  - {shape: {box: {size: [0.4, 0.4, 0.4]}}, mass: 1, position: [0.7, 0, -0.2]}\n"));
  fall.seconds(0.48);
  EXPECT_NEAR(fall.velocity(3).z(), -9.81 * 0.48, 1e-6);
  EXPECT_NEAR(fall.position(3).x(), 0.7, 1e-6);
  Experiment belt(
      scene_from_text(head +
                      "  - {shape: {box: {size: [1, 1, 1]}}, motion: kinematic, velocity: [-2, 0, 0], points: [[0, 0, "
                      "-0.5], [1, 0, -0.5], [2, 0, -0.5]]}\n  - {shape: {box: {size: [0.4, 0.4, 0.4]}}, mass: 1, position: "
                      "[0, 0, 0.2]}\n"));
  belt.seconds(0.8);
  EXPECT_LT((belt.position(3) - Vec3(0, 0, 0.2)).norm(), 1e-4);
}

// What rises is no seam: a wall on the floor, and a step higher than the box's centre.
TEST_P(Seams, WhatRisesStops) {
  const auto [solver, substeps] = GetParam();
  for (const double top : {0.25, 1.0}) {
    const std::string floor =
        "  - {shape: {box: {size: [1, 1, 1]}}, motion: fixed, position: [0, 0, -0.5]}\n  - {shape: {box: {size: "
        "[1, 1, 1]}}, motion: fixed, position: [1, 0, " +
        number(top - 0.5) + "]}\n";
    Experiment run = sliding(floor, sliders[0], 2, 0, "", solver, substeps);
    run.seconds(0.8);
    EXPECT_LT(run.position(2).x(), 0.3 + 1e-3) << top;
    EXPECT_LT(std::abs(run.velocity(2).x()), 1e-2) << top;
  }
}

INSTANTIATE_TEST_SUITE_P(Solvers, Seams,
                         testing::Combine(testing::Values("accelerated_jacobi", "gauss_seidel"), testing::Values(1, 4)));

}  // namespace unibody::small_worlds::seams_test
