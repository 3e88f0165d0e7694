// Bodies that adhere: the forces at which they come apart or slide, in closed form, with both solvers, at 1 and 4 substeps.
#include <gtest/gtest.h>

#include <cmath>

#include "small_worlds.hpp"

namespace unibody::small_worlds::adhesion_test {

namespace {

constexpr double g = 9.81;

std::string head(const std::string& solver, int substeps, const std::string& material, const std::string& gravity = "[0, 0, 0]") {
  return "time: {substeps: " + std::to_string(substeps) + "}\nsolver: {name: " + solver + "}\ngravity: " + gravity +
         "\nmaterials: {m: {" + material + "}}\nbodies:\n";
}
std::string number(double x) { return std::to_string(x); }

// Below a ceiling, which a body of 1 kg touches.
std::string hanging(const std::string& shape, double half) {
  return "  - {shape: {box: {size: [1, 1, 0.2]}}, motion: fixed, position: [0, 0, 0.1]}\n  - {shape: {" + shape +
         "}, mass: 1, position: [0, 0, " + number(-half) + "]}\n";
}

}  // namespace

class AdhesionOf : public testing::TestWithParam<std::tuple<const char*, int>> {};

// What weighs less than the attraction hangs there for good; what weighs more falls from rest.
TEST_P(AdhesionOf, ABodyHangsFromACeiling) {
  const auto [solver, substeps] = GetParam();
  const std::pair<const char*, double> shapes[] = {
      {"sphere: {radius: 0.1}", 0.1}, {"box: {size: [0.2, 0.2, 0.2]}", 0.1}, {"cylinder: {radius: 0.1, length: 0.2}", 0.1}};
  for (const auto& [shape, half] : shapes) {
    const auto scene = [&, half = half, shape = shape](double over_weight) {
      return scene_from_text(head(solver, substeps, "friction: 0.5, adhesion: " + number(over_weight * g), "[0, 0, -9.81]") +
                             hanging(shape, half));
    };
    Experiment hangs(scene(1.01)), falls(scene(0.99));
    hangs.seconds(4);
    EXPECT_NEAR(hangs.position(1).z(), -half, 2e-5) << shape;
    EXPECT_NEAR(hangs.normal_force(0, 1), 0.01 * g, 1e-3 * g) << shape;  // beside the attraction
    // Within the range of 2 mm the attraction leaves 0.0981 m/s^2 of gravity; it is beyond it after 0.2 s, at 0.02 m/s.
    const double out = std::sqrt(2 * 0.002 / (0.01 * g)), speed = 0.01 * g * out;
    falls.seconds(0.48);
    EXPECT_NEAR(falls.velocity(1).z(), -speed - g * (0.48 - out), 2 * g * falls.h()) << shape;
  }
}

// 3/2 pi gamma R of a ball on a flat face, and of two balls whose R is R_a R_b / (R_a + R_b).
TEST_P(AdhesionOf, ThePullOffForceOfASurfaceEnergy) {
  const auto [solver, substeps] = GetParam();
  const double energy = 20, on_face = 1.5 * M_PI * energy * 0.1, of_two = 1.5 * M_PI * energy * (0.1 * 0.3 / 0.4);
  for (const double share : {0.98, 1.02}) {
    const std::string material = head(solver, substeps, "friction: 0.5, surface_energy: " + number(energy));
    const auto pulled = [&](double force) { return ", force: [0, 0, " + number(-share * force) + "]}\n"; };
    Experiment face(scene_from_text(material + "  - {shape: {plane: {normal: [0, 0, -1]}}}\n" +
                                    "  - {shape: {sphere: {radius: 0.1}}, mass: 1, position: [0, 0, -0.1]" + pulled(on_face)));
    Experiment two(scene_from_text(material + "  - {shape: {sphere: {radius: 0.3}}, motion: fixed, position: [0, 0, 0.3]}\n" +
                                   "  - {shape: {sphere: {radius: 0.1}}, mass: 1, position: [0, 0, -0.1]" + pulled(of_two)));
    for (Experiment* run : {&face, &two}) {
      run->seconds(1.6);
      if (share < 1)
        EXPECT_NEAR(run->position(1).z(), -0.1, 2e-5);
      else
        EXPECT_LT(run->position(1).z(), -0.15);
    }
  }
}

// A box on a wall: friction is bounded by mu F, whatever presses the box on.
TEST_P(AdhesionOf, TheConeOfFrictionHasItsTipAtThePullOffForce) {
  const auto [solver, substeps] = GetParam();
  const auto scene = [&](double adhesion) {
    return scene_from_text(head(solver, substeps, "friction: 0.4, adhesion: " + number(adhesion), "[0, 0, -9.81]") +
                           "  - {shape: {plane: {normal: [1, 0, 0]}}}\n"
                           "  - {shape: {box: {size: [0.2, 0.4, 0.4]}}, mass: 1, position: [0.1, 0, 0]}\n");
  };
  Experiment sticks(scene(1.1 * g / 0.4)), slides(scene(0.6 * g / 0.4));
  sticks.seconds(4), slides.seconds(0.8);
  EXPECT_NEAR(sticks.position(1).z(), 0, 1e-4);
  EXPECT_NEAR(slides.velocity(1).z(), -0.4 * g * 0.8, 1e-4);
  EXPECT_NEAR(slides.position(1).x(), 0.1, 2e-5);
}

// Two balls that turn about each other: F holds m w^2 r.
TEST_P(AdhesionOf, TwoBallsTurnAboutEachOther) {
  const auto [solver, substeps] = GetParam();
  const double spin = 2, needed = 1 * spin * spin * 0.1;
  for (const double share : {1.1, 0.9}) {
    Experiment run(
        scene_from_text(head(solver, substeps, "friction: 0, adhesion: " + number(share * needed)) +
                        "  - {shape: {sphere: {radius: 0.1}}, mass: 1, position: [0.1, 0, 0], velocity: [0, 0.2, 0]}\n"
                        "  - {shape: {sphere: {radius: 0.1}}, mass: 1, position: [-0.1, 0, 0], velocity: [0, -0.2, 0]}\n"));
    const Vec3 turning = run.angular_momentum();
    run.seconds(3.2);
    const double apart = (run.position(0) - run.position(1)).norm();
    if (share > 1)
      EXPECT_NEAR(apart, 0.2, 2e-4);
    else
      EXPECT_GT(apart, 0.25);
    EXPECT_LT(run.momentum().norm(), 1e-12);
    EXPECT_LT((run.angular_momentum() - turning).norm(), 0.02 * turning.norm());
  }
}

// The attraction of a ball that bounces does not make it jump where it lies.
TEST_P(AdhesionOf, WhatLiesStays) {
  const auto [solver, substeps] = GetParam();
  for (const char* gravity : {"[0, 0, 0]", "[0, 0, -9.81]"}) {
    Experiment run(scene_from_text(head(solver, substeps, "friction: 0.5, restitution: 0.8, adhesion: 100", gravity) +
                                   "  - {shape: {plane: {normal: [0, 0, 1]}}}\n"
                                   "  - {shape: {sphere: {radius: 0.1}}, mass: 1, position: [0, 0, 0.1]}\n"));
    for (int k = 0; k < 1 / run.h(); ++k) {
      run.step();
      ASSERT_NEAR(run.position(1).z(), 0.1, 2e-5) << gravity << ' ' << k;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Solvers, AdhesionOf,
                         testing::Combine(testing::Values("accelerated_jacobi", "gauss_seidel"), testing::Values(1, 4)));

// Within the range the attraction is what it is in contact; the margin of contacts reaches as far.
TEST(Adhesion, ItActsAsFarAsItsRange) {
  const auto scene = [](double gap) {
    return scene_from_text(head("accelerated_jacobi", 1, "adhesion: 2, adhesion_range: 0.03, friction: 0") +
                           "  - {shape: {sphere: {radius: 0.1}}, motion: fixed}\n"
                           "  - {shape: {sphere: {radius: 0.1}}, mass: 1, position: [" +
                           number(0.2 + gap) + ", 0, 0]}\n");
  };
  Experiment within(scene(0.029)), beyond(scene(0.031));
  within.steps(5), beyond.steps(5);
  EXPECT_NEAR(within.velocity(1).x(), -2 * 5 * 0.016, 1e-12);
  EXPECT_EQ(beyond.velocity(1).x(), 0);
}

// Grains that fall on a floor stand in a heap that is the steeper the more they adhere.
TEST(Adhesion, AHeapIsTheSteeperTheMoreItsGrainsAdhere) {
  double last = 1e9;
  for (const double share : {0.0, 2.0, 10.0}) {  // of a grain's weight
    Experiment run(scene_from_text(
        "planar: true\n" + head("accelerated_jacobi", 1, "friction: 0.4, adhesion: " + number(share * 0.1 * g), "[0, 0, -9.81]") +
        "  - {shape: {plane: {normal: [0, 0, 1]}}}\n"
        "  - {shape: {disc: {radius: 0.05}}, mass: 0.1, lattice: {count: 60, columns: [6, 1], "
        "spacing: [0.11, 0.11, 0.11], height: 0.06, jitter: 0.004}}\n"));
    run.seconds(3);
    double width = 0;  // root mean square
    for (Id id = 1; id <= 60; ++id) width += run.position(id).x() * run.position(id).x() / 60;
    width = std::sqrt(width);
    EXPECT_LT(width, 0.9 * last) << share;
    last = width;
  }
}

TEST(RanksAdhesion, StepsHaveTheSameBits) {
  const std::string text = head("accelerated_jacobi", 1, "friction: 0.5, adhesion: 2, surface_energy: 1", "[0, 0, -9.81]") +
                           "  - {shape: {plane: {normal: [0, 0, 1]}}}\n"
                           "  - {shape: {sphere: {radius: 0.1}}, mass: 0.3, lattice: {count: 24, columns: [4, 2], "
                           "spacing: [0.21, 0.21, 0.21], height: 0.12, jitter: 0.004}}\n"
                           "  - {shape: {box: {size: [0.2, 0.2, 0.2]}}, mass: 0.3, position: [0, 0, 0.7], lattice: {count: 8, "
                           "columns: [2, 2], spacing: [0.3, 0.3, 0.3], height: 0.1}}\n";
  Experiment alone(scene_from_text(text)), here(scene_from_text(text), MPI_COMM_WORLD);
  alone.steps(40), here.steps(40);
  for (std::size_t i = 0; i < here.world().homes; ++i) {
    const Id id = here.world().id[i];
    EXPECT_EQ(here.world().position[i], alone.position(id)) << id;
    EXPECT_EQ(here.world().velocity[i], alone.velocity(id)) << id;
  }
}

}  // namespace unibody::small_worlds::adhesion_test
