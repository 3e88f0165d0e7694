// Bodies that land on one end, and those that spin as they land: what their other ends do within the step.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "small_worlds.hpp"

namespace unibody::small_worlds::far_ends_test {

class FarEnds : public testing::TestWithParam<const char*> {};

namespace {

const char* const grounds[] = {"{shape: {plane: {normal: [0, 0, 1]}}}",
                               "{shape: {box: {size: [40, 40, 1]}}, motion: fixed, position: [0, 0, -0.5]}"};

std::string text_of(const Vec3& v) {
  return "[" + std::to_string(v.x()) + ", " + std::to_string(v.y()) + ", " + std::to_string(v.z()) + "]";
}

}  // namespace

// What falls on one end without friction and with e = 1 goes on at v' = J/m - v and turns at J a/I, with the impulse
// J = 2 v / (1/m + a^2/I), a how far the end lies beside the centre and I the moment across the body. It turns from when it
// lands, not from when the step starts: the angle was too large by the time before times the rate, and the end that had landed
// went in.
TEST_P(FarEnds, WhatLandsOnOneEndTurnsFromThereOn) {
  const double v = 1, h = 0.016, tilt = 60 * M_PI / 180, s = std::sin(tilt), c = std::cos(tilt);
  const struct {
    const char* shape;
    double beside, below;  // m, the end that lands from the centre
  } shapes[] = {
      {"box: {size: [0.1, 0.1, 0.4]}", 0.2 * s - 0.05 * c, 0.2 * c + 0.05 * s},
      {"cylinder: {radius: 0.05, length: 0.4}", 0.2 * s - 0.05 * c, 0.2 * c + 0.05 * s},
      {"capsule: {radius: 0.05, length: 0.3}", 0.15 * s, 0.15 * c + 0.05},
      {"compound: {parts: [{shape: {box: {size: [0.1, 0.1, 0.2]}}, position: [0, 0, 0.1]}, {shape: {box: {size: [0.1, 0.1, "
       "0.2]}}, position: [0, 0, -0.1]}]}",
       0.2 * s - 0.05 * c, 0.2 * c + 0.05 * s},
      {"compound: {parts: [{shape: {sphere: {radius: 0.05}}, position: [0, 0, 0.15]}, {shape: {sphere: {radius: 0.05}}, "
       "position: [0, 0, -0.15]}]}",
       0.15 * s, 0.15 * c + 0.05}};
  for (const auto& [shape, beside, below] : shapes)
    for (const char* ground : grounds)
      for (const int substeps : {1, 4})
        for (const double before : {0.1, 0.4, 0.9}) {  // of the frame, when it lands
          Experiment run(scene_from_text(
              "gravity: [0, 0, 0]\ntime: {frame: 0.016, substeps: " + std::to_string(substeps) + "}\nsolver: {name: " +
              GetParam() + "}\nmaterials: {m: {friction: 0, restitution: 1}}\nbodies:\n  - " + ground + "\n  - {shape: {" +
              shape + "}, mass: 1, orientation: {axis: [0, 1, 0], angle: 60}, velocity: [0, 0, -1], position: [0, 0, " +
              std::to_string(below + before * h * v) + "]}\n"));
          const double height = run.position(1).z();
          const double moment = run.world().properties[run.slot(1)].inertia.maxCoeff();
          const Quat start = run.state(1).orientation;
          run.seconds(h);
          const double impulse = 2 * v / (1 + beside * beside / moment), rate = impulse * beside / moment,
                       left = (1 - before) * h;
          const Quat turned = run.state(1).orientation * start.conjugate();
          const std::string which = std::string(shape).substr(0, 40) + " on " + std::string(ground).substr(0, 15);
          EXPECT_NEAR(run.velocity(1).z(), impulse - v, 1e-6) << which << before;
          EXPECT_NEAR(run.state(1).angular_velocity.y(), rate, 1e-5) << which << before;
          EXPECT_NEAR(run.position(1).z(), height - v * before * h + (impulse - v) * left, 2e-6)
              << which << before;  // written to 1e-6
          EXPECT_NEAR(2 * std::atan2(turned.y(), turned.w()), rate * left, 1e-3) << which << ' ' << substeps << ' ' << before;
        }
}

// A body that spins as it lands goes into the ground by no more than what its turn in the step, seen as a straight motion, leaves
// out: half of the angle's square times how far it reaches. Parts that lay between others at the step's start went in by up to
// 80 mm, and corners of hulls that were not the lowest then by 50 mm, both in steps that counted as converged.
TEST_P(FarEnds, WhatSpinsIsHeldWhereItComesDown) {
  const double h = 0.016;
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  const auto some = [&] { return Vec3(normal(random), normal(random), normal(random)); };
  std::string hull = "hull: {points: [";
  for (int k = 0; k < 100; ++k) hull += (k ? ", " : "") + text_of(some().normalized().cwiseProduct(Vec3(0.15, 0.1, 0.07)));
  const std::string shapes[] = {
      "compound: {parts: [{shape: {box: {size: [0.1, 0.1, 0.3]}}, position: [0, 0, 0]}, {shape: "
      "{sphere: {radius: 0.1}}, position: [0, 0, 0.2]}]}",
      "compound: {parts: [{shape: {box: {size: [0.1, 0.1, 0.15]}}, position: [0, 0, 0.075]}, {shape: "
      "{box: {size: [0.1, 0.1, 0.15]}}, position: [0, 0, -0.075]}]}",
      "cylinder: {radius: 0.15, length: 0.06}", hull + "]}"};
  for (const std::string& shape : shapes)
    for (const char* ground : grounds)
      for (int k = 0; k < 12; ++k) {
        const Vec3 axis = some().normalized();
        Experiment run(scene_from_text("time: {frame: 0.016}\nsolver: {name: " + std::string(GetParam()) +
                                       "}\nmaterials: {m: {friction: 0.3}}\nbodies:\n  - " + ground + "\n  - {shape: {" + shape +
                                       "}, mass: 1, orientation: {axis: " + text_of(axis) +
                                       ", angle: " + std::to_string(180 * normal(random)) + "}, velocity: " + text_of(some()) +
                                       ", angular_velocity: " + text_of(12 * some()) + ", position: [0, 0, " +
                                       std::to_string(1 + 0.05 * k) + "]}\n"));
        const double reach = bounding_radius(run.world().properties[run.slot(1)].shape);
        double depth = 0;  // m, which is taken out in a few steps
        for (int step = 0; step < 45; ++step) {
          const double before = run.state(1).angular_velocity.norm();
          run.step();
          const double angle = h * std::max(before, run.state(1).angular_velocity.norm());
          const double allowed = std::max(depth, 0.5 * angle * angle * reach + 1e-3);
          depth = run.penetration();
          EXPECT_LT(depth, allowed + 1e-9) << shape.substr(0, 20) << ground << k << ' ' << step;
        }
      }
}

INSTANTIATE_TEST_SUITE_P(Solvers, FarEnds, testing::Values("accelerated_jacobi", "gauss_seidel"));

}  // namespace unibody::small_worlds::far_ends_test
