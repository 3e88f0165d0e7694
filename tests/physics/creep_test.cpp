// What sticks stays where it is, although its solver leaves something undone in every step.
#include <gtest/gtest.h>

#include <cmath>

#include "small_worlds.hpp"

namespace unibody::small_worlds::creep_test {

namespace {

std::string header(const char* solver, int substeps, double frame, const std::string& more = "") {
  return "time: {frame: " + std::to_string(frame) + ", frames: 1, substeps: " + std::to_string(substeps) +
         "}\nsolver: {name: " + solver + more + "}\n";
}

// Two fingers press a cube with 20 N each, as motors of sliders: friction holds 16 times its weight. aside: m, of the cube's
// centre from the middle of the fingers, along their breadth.
std::string gripper(const char* solver, int substeps, double aside = 0) {
  return header(solver, substeps, 0.004) + R"(
materials: {rubber: {friction: 0.8}}
bodies:
  - {name: cube, shape: {box: {size: [0.05, 0.05, 0.05]}}, mass: 0.2, position: [0, )" +
         std::to_string(aside) + R"(, 0.525]}
  - {name: hand, shape: {box: {size: [0.2, 0.06, 0.03]}}, motion: fixed, position: [0, 0, 0.64]}
  - {name: left, shape: {box: {size: [0.02, 0.04, 0.1]}}, mass: 0.1, position: [-0.036, 0, 0.57]}
  - {name: right, shape: {box: {size: [0.02, 0.04, 0.1]}}, mass: 0.1, position: [0.036, 0, 0.57]}
joints:
  - {type: slider, bodies: [left, hand], anchor: [-0.036, 0, 0.57], axis: [1, 0, 0], motor: {speed: 0.2, max_force: 20}}
  - {type: slider, bodies: [right, hand], anchor: [0.036, 0, 0.57], axis: [1, 0, 0], motor: {speed: -0.2, max_force: 20}}
)";
}

struct Case {
  const char* solver;
  int substeps;
};
void PrintTo(const Case& c, std::ostream* out) { *out << c.solver << ' ' << c.substeps; }

class Creep : public testing::TestWithParam<Case> {};
INSTANTIATE_TEST_SUITE_P(Solvers, Creep,
                         testing::Values(Case{"accelerated_jacobi", 1}, Case{"accelerated_jacobi", 4},
                                         Case{"accelerated_jacobi", 16}, Case{"gauss_seidel", 1}, Case{"gauss_seidel", 4},
                                         Case{"gauss_seidel", 16}));

// In 10 s by less than a thousandth of a finger's thickness.
TEST_P(Creep, AGripperHolds) {
  Experiment run(scene_from_text(gripper(GetParam().solver, GetParam().substeps)));
  run.seconds(1);
  const double before = run.position(0).z() - run.position(2).z();
  run.seconds(5);
  EXPECT_NEAR(run.position(0).z() - run.position(2).z(), before, 0.5e-3 * 0.02);
}

// A cube that is held a centimetre beside its centre of mass does not turn about the axis through the fingers either.
TEST_P(Creep, AGripperHoldsWhatWouldTurn) {
  Experiment run(scene_from_text(gripper(GetParam().solver, GetParam().substeps, 0.01)));
  run.seconds(1);
  const Quat before = run.world().orientation[0];
  const Vec3 place = run.position(0);
  run.seconds(5);
  EXPECT_LT(run.world().orientation[0].angularDistance(before), 0.5e-6);  // rad
  EXPECT_LT((run.position(0) - place).norm(), 0.5e-8);                    // m
}

// Boxes of 40 x 40 x 10 cm, or of another edge, each so far beside the one below it (m), on a plane.
std::string tower(int boxes, double aside, const std::string& edge = "0.4") {
  std::string text = "bodies:\n  - {shape: {plane: {normal: [0, 0, 1]}}}\n";
  for (int k = 0; k < boxes; ++k)
    text += "  - {shape: {box: {size: [" + edge + ", " + edge + ", 0.1]}}, mass: 1, position: [" + std::to_string(aside * k) +
            ", 0, " + std::to_string(0.05 + 0.1 * k) + "]}\n";
  return text;
}

constexpr double bound = 1e-3 * 0.1;  // m, for boxes of 0.1 m on each other: a thousandth of the edge

// A stack on a slope at nine tenths of what friction holds, in steps of one stage, which start from a share of the last forces,
// and of two.
TEST_P(Creep, AStackOnASlopeStays) {
  const std::string two_stages = header(GetParam().solver, GetParam().substeps, 0.016);
  const std::string one_stage = header(GetParam().solver, GetParam().substeps, 0.016, ", stages: position");
  for (const std::string& settings : {one_stage, two_stages}) {
    SCOPED_TRACE(settings);
    Experiment run(scene_from_text(settings + "gravity: [4.0, 0, -9]\n" + tower(3, 0)));
    run.seconds(2);
    const Vec3 before = run.position(3);
    run.seconds(10);
    EXPECT_LT((run.position(3) - before).norm(), bound);
  }
}

// Boxes of 0.1 m on each other, every second one so far aside (m).
std::string zigzag(int boxes, double aside) {
  std::string text = "gravity: [0, 0, -9.81]\nbodies:\n  - {shape: {plane: {normal: [0, 0, 1]}}}\n";
  for (int k = 0; k < boxes; ++k)
    text += "  - {shape: {box: {size: [0.1, 0.1, 0.1]}}, mass: 1, position: [" + std::to_string(k % 2 * aside) + ", 0, " +
            std::to_string(0.05 + 0.1 * k) + "]}\n";
  return text;
}

// Four stacks stand askew on the level; the steps of the other four, on the level and on slopes, take more than 50 iterations.
// All run at default settings.
TEST_P(Creep, StacksStay) {
  const std::string settings = header(GetParam().solver, GetParam().substeps, 0.016);
  for (const std::string& text :
       {zigzag(2, 0.01), zigzag(2, 0.025), zigzag(3, 0.025), zigzag(5, 0.01), "gravity: [0, 0, -9.81]\n" + tower(5, 0, "0.1"),
        "gravity: [0.981, 0, -9.81]\n" + tower(5, 0, "0.1"), "gravity: [2.943, 0, -9.81]\n" + tower(3, 0, "0.1"),
        "gravity: [1.962, 0, -9.81]\n" + tower(5, 0)}) {
    Experiment run(scene_from_text(settings + text));
    run.seconds(2);
    const std::vector<Vec3> before = run.world().position;
    run.seconds(10);
    for (std::size_t i = 0; i < run.world().homes; ++i)
      EXPECT_LT((run.world().position[i] - before[i]).norm(), bound) << text << i;
  }
}

// Bricks in two courses, in which each upper one rests on two, hold each other in more ways than one: what their contacts
// remember must not set them against each other. They come to rest, to round-off; in steps of a whole frame they move by no
// more than the tolerance in each, 2e-5 of their height.
TEST_P(Creep, AWallComesToRest) {
  std::string text =
      "gravity: [0, 0, -9.81]\nmaterials: {brick: {friction: 0.6}}\nperiodic: {x: [0.05, 1.05]}\nbodies:\n"
      "  - {shape: {plane: {normal: [0, 0, 1]}}}\n";
  for (int k = 0; k < 8; ++k)
    text += "  - {shape: {box: {size: [0.24, 0.12, 0.1]}}, mass: 2, position: [" + std::to_string(0.125 * k) + ", 0, " +
            (k % 2 == 0 ? "0.05" : "0.15") + "]}\n";
  Experiment run(scene_from_text(header(GetParam().solver, GetParam().substeps, 0.016) + text));
  run.seconds(4);
  for (int k = 1; k <= 8; ++k)
    EXPECT_LT(run.velocity(k).norm(), GetParam().substeps == 1 ? 2e-5 * 0.1 / 0.016 : 1e-8) << k;  // m/s
}

// Towers of ten boxes lean or stand on a slope, far from where they would fall. Their steps do not converge with 50 iterations,
// and what creeps must not add up to a fall, whatever else is in the scene. A tower moves by less than a tenth of a box's longer
// edge.
TEST_P(Creep, TowersStand) {
  const std::string settings = header(GetParam().solver, GetParam().substeps, 0.016, ", iterations: 50");
  const std::string far_cloth =
      "cloths:\n  - {grid: {size: [0.4, 0.4], nodes: [5, 5]}, mass: 0.001, thickness: 0.01, position: [0, 0, 100], "
      "pins: [{node: [0, 0]}, {node: [4, 0]}, {node: [0, 4]}, {node: [4, 4]}]}\n";
  for (const std::string& text : {settings + tower(10, 0.02), settings + tower(10, 0.02) + far_cloth,
                                  settings + "gravity: [2.0, 0, -9.6]\n" + tower(10, 0)}) {
    Experiment run(scene_from_text(text));
    run.seconds(2);
    const Vec3 before = run.position(10);
    run.seconds(5);
    EXPECT_LT((run.position(10) - before).norm(), 0.2 / 10) << text;
  }
}

// What slides is not held: the closed form of a box on a slope that is steeper than friction holds.
TEST_P(Creep, WhatSlidesHasNone) {
  Experiment run(scene_from_text(header(GetParam().solver, GetParam().substeps, 0.016, ", stages: position") + R"(
gravity: [5, 0, -9]
bodies:
  - {shape: {plane: {normal: [0, 0, 1]}}}
  - {shape: {box: {size: [0.4, 0.4, 0.1]}}, mass: 1, position: [0, 0, 0.05]}
)"));
  run.seconds(1.6);
  EXPECT_NEAR(run.velocity(1).x(), (5 - 0.5 * 9) * 1.6, 1e-3);
}

}  // namespace

}  // namespace unibody::small_worlds::creep_test
