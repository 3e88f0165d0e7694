// Bodies that the scene moves in time, and what touches them or hangs on them.
#include <gtest/gtest.h>

#include <cmath>

#include "small_worlds.hpp"

namespace unibody::small_worlds::motion_in_time_test {

class MotionInTime : public testing::TestWithParam<const char*> {
 protected:
  std::string head(int substeps = 1) const {
    return "time: {frame: 0.01, substeps: " + std::to_string(substeps) + "}\nsolver: {name: " + std::string(GetParam()) + "}\n";
  }
};

// By the integral of its velocity, or by its path, a body is where it should be after each step, whatever the step.
TEST_P(MotionInTime, ABodyIsWhereItsLawSays) {
  for (const int substeps : {1, 3}) {
    Experiment run(scene_from_text(
        head(substeps) +
        "bodies:\n"
        "  - {shape: {sphere: {radius: 0.1}}, motion: kinematic, velocity: [{sine: {amplitude: 0.6, frequency: 1.3}}, 0, 0.25]}\n"
        "  - {shape: {sphere: {radius: 0.1}}, motion: kinematic, position: [0, 5, 0],\n"
        "     path: {table: [[0, 0, 0, 0], [0.314, 1, 0, 2], [0.7, 1, -1, 2]], between: smooth}}\n"
        "  - {shape: {sphere: {radius: 0.1}}, motion: kinematic, position: [0, 9, 0], velocity: [0, 0, [[0.2, 0], [0.4, 1]]]}\n"
        "  - {shape: {sphere: {radius: 0.1}}, motion: kinematic, position: [0, 12, 0], angular_velocity: [0, 0, [[0, 0], [1, "
        "2]]]}\n"
        "  - {shape: {sphere: {radius: 0.1}}, mass: 1, position: [0, 20, 0]}\n"));
    const double w = 2 * M_PI * 1.3;
    const auto smooth = [](double s) { return s * s * (3 - 2 * s); };
    for (int k = 1; k <= 90 * substeps; ++k) {
      run.step();
      const double t = k * run.h(), ramp = std::clamp(t - 0.2, 0.0, 0.2), turn = t * t;
      EXPECT_LT((run.position(0) - Vec3(0.6 / w * (1 - std::cos(w * t)), 0, 0.25 * t)).norm(), 1e-13);
      const double x = smooth(std::min(1.0, t / 0.314)), y = smooth(std::clamp((t - 0.314) / 0.386, 0.0, 1.0));
      EXPECT_LT((run.position(1) - Vec3(x, 5 - y, 2 * x)).norm(), 1e-13);
      EXPECT_LT((run.position(2) - Vec3(0, 9, 2.5 * ramp * ramp + std::max(0.0, t - 0.4))).norm(), 1e-13);
      const Quat about_z(Eigen::AngleAxisd(turn, Vec3::UnitZ()));
      EXPECT_LT(run.state(3).orientation.angularDistance(about_z), 1e-12);
    }
  }
}

// On a table that speeds up at a, a box goes along where friction bears it, mu g > a; else friction gives it mu g.
TEST_P(MotionInTime, ATableThatSpeedsUpCarriesWhatFrictionBears) {
  const double g = 9.81, mu = 0.3;
  for (const double a : {2.0, 5.0}) {
    Experiment run(scene_from_text(
        head() +
        "materials: {m: {friction: 0.3}}\nbodies:\n"
        "  - {shape: {box: {size: [20, 1, 0.1]}}, motion: kinematic, position: [0, 0, -0.05], velocity: [[[0, 0], [1, " +
        std::to_string(a) + "]], 0, 0]}\n  - {shape: {box: {size: [0.4, 0.4, 0.1]}}, mass: 3, position: [0, 0, 0.05]}\n"));
    run.seconds(0.8);
    // The table moves at the mean of its velocity over a step; in the first one that is too slow for the box to slide.
    const double table = a * (0.8 - 0.5 * run.h()), slides = 0.5 * a * run.h() + mu * g * (0.8 - run.h());
    EXPECT_NEAR(run.velocity(1).x(), a < mu * g ? table : slides, 1e-4) << a;
    EXPECT_NEAR(run.position(0).x(), 0.5 * a * 0.64, 1e-12);
  }
}

// A plate that is drawn from under a ball at 0.3 s lets it fall from then on: h (n + 1) g / 2 n h in n steps of implicit Euler.
TEST_P(MotionInTime, AGateOpens) {
  Experiment run(
      scene_from_text(head() + "materials: {m: {friction: 0}}\nbodies:\n"
                               "  - {name: gate, shape: {box: {size: [1, 1, 0.1]}}, motion: kinematic, position: [0, 0, -0.05],\n"
                               "     path: {table: [[0, 0, 0, 0], [0.3, 0, 0, 0], [0.31, 3, 0, 0]]}}\n"
                               "  - {shape: {sphere: {radius: 0.1}}, mass: 1, position: [0, 0, 0.1]}\n"));
  run.seconds(0.3);
  EXPECT_NEAR(run.position(1).z(), 0.1, 1e-5);
  run.seconds(0.3);
  const double n = 29;  // the plate is still under it where the step begins in which it goes
  EXPECT_NEAR(run.position(1).z(), 0.1 - 0.5 * 9.81 * run.h() * run.h() * n * (n + 1), 0.01);
  EXPECT_NEAR(run.velocity(1).z(), -9.81 * n * run.h(), 0.1);
}

// Two jaws close on a ball, wait, and lift it; friction alone holds it.
TEST_P(MotionInTime, AGripperClosesAndLifts) {
  Experiment run(scene_from_text(head(4) +
                                 "materials: {rubber: {friction: 1}}\nbodies:\n"
                                 "  - {shape: {plane: {normal: [0, 0, 1]}}}\n"
                                 "  - {shape: {box: {size: [0.1, 0.3, 0.3]}}, motion: kinematic, position: [-0.3, 0, 0.2],\n"
                                 "     path: [[[0, 0], [0.5, 0.1505]], 0, [[0.7, 0], [1.7, 0.5]]]}\n"
                                 "  - {shape: {box: {size: [0.1, 0.3, 0.3]}}, motion: kinematic, position: [0.3, 0, 0.2],\n"
                                 "     path: [[[0, 0], [0.5, -0.1505]], 0, [[0.7, 0], [1.7, 0.5]]]}\n"
                                 "  - {shape: {sphere: {radius: 0.1}}, mass: 0.5, position: [0, 0, 0.1]}\n"));
  run.seconds(0.7);
  EXPECT_NEAR(run.position(3).z(), 0.1, 0.003);
  run.seconds(1.3);
  EXPECT_NEAR(run.position(3).z(), 0.6, 0.02);
  EXPECT_LT(run.velocity(3).norm(), 0.02);
}

// A strong motor's wheel turns as its target does: by the mean of the speed over each step, or to the place at its end.
TEST_P(MotionInTime, AMotorFollowsItsTarget) {
  Experiment run(
      scene_from_text("time: {frame: 0.01}\nsolver: {tolerance: 1e-12, iterations: 200, name: " + std::string(GetParam()) +
                      "}\ngravity: [0, 0, 0]\nbodies:\n"
                      "  - {name: fast, shape: {sphere: {radius: 0.1}}, mass: 1}\n"
                      "  - {name: placed, shape: {sphere: {radius: 0.1}}, mass: 1, position: [1, 0, 0]}\n"
                      "joints:\n"
                      "  - {type: hinge, bodies: [fast, world], anchor: [0, 0, 0], axis: [0, 0, 1],\n"
                      "     motor: {speed: {sine: {amplitude: 2, frequency: 0.7, mean: 1}}, max_torque: 1000}}\n"
                      "  - {type: hinge, bodies: [placed, world], anchor: [1, 0, 0], axis: [0, 0, 1],\n"
                      "     motor: {angle: {table: [[0, 0], [0.5, 60], [0.9, -30]], between: smooth}, max_torque: 1000}}\n"));
  const double w = 2 * M_PI * 0.7;
  const auto smooth = [](double s) { return s * s * (3 - 2 * s); };
  double turned = 0;
  for (int k = 1; k <= 120; ++k) {
    run.step();
    const double t = k * run.h(), rate = 1 + 2 / w * (std::cos(w * (t - run.h())) - std::cos(w * t)) / run.h();
    const double degrees = t < 0.5 ? 60 * smooth(t / 0.5) : 60 - 90 * smooth(std::min(1.0, (t - 0.5) / 0.4));
    const std::vector<JointState> states = run.simulation->joint_states();
    turned += rate * run.h();
    EXPECT_NEAR(states[0].coordinate, turned, 1e-6) << t;
    EXPECT_NEAR(states[1].coordinate, degrees * M_PI / 180, 1e-6) << t;
  }
}

// Two boxes slide. The friction of one's material changes, and meets the ground's by the geometric mean of their means over the
// step; that of the other's pair with the ground is listed. Each loses g times the integral of its coefficient.
TEST_P(MotionInTime, FrictionThatChangesSlowsByItsIntegral) {
  for (const int substeps : {1, 4}) {
    Experiment run(
        scene_from_text("time: {frame: 0.016, substeps: " + std::to_string(substeps) +
                        "}\nsolver: {tolerance: 1e-12, iterations: 400, name: " + std::string(GetParam()) +
                        "}\nmaterials:\n  ground: {friction: 0.9}\n  wet: {friction: [[0.32, 0], [0.8, 0.4]]}\n"
                        "  waxed: {friction: 0.2}\n"
                        "  pairs: [{between: [ground, waxed], friction: {sine: {amplitude: 0.1, frequency: 2, mean: 0.1}}}]\n"
                        "bodies:\n  - {shape: {plane: {normal: [0, 0, 1]}}, material: ground}\n"
                        "  - {shape: {box: {size: [0.6, 0.6, 0.02]}}, mass: 2, position: [0, 0, 0.01], velocity: [9, 0, 0], "
                        "material: wet}\n"
                        "  - {shape: {box: {size: [0.6, 0.6, 0.02]}}, mass: 2, position: [0, 5, 0.01], velocity: [0, 9, 0], "
                        "material: waxed}\n"));
    const TimeValue wet = TimeValue::table({{0.32, 0}, {0.8, 0.4}}, TimeValue::Between::linear, false);
    double of_wet = 0;
    for (int k = 1; k <= 64 * substeps; ++k) {
      run.step();
      const double t = k * run.h(), w = 4 * M_PI;
      of_wet += run.h() * std::sqrt(0.9 * wet.mean(t - run.h(), t));
      const double of_waxed = 0.1 * t + 0.1 * (1 - std::cos(w * t)) / w;
      EXPECT_NEAR(run.velocity(1).x(), 9 - 9.81 * of_wet, 1e-6) << substeps << ' ' << t;
      EXPECT_NEAR(run.velocity(2).y(), 9 - 9.81 * of_waxed, 1e-6) << substeps << ' ' << t;
    }
  }
}

// Gravity, forces and torques that change: a free body's momenta are the integrals of what acts on it, whatever the step.
TEST_P(MotionInTime, WhatActsOnAFreeBodyIsIntegrated) {
  for (const int substeps : {1, 4}) {
    Experiment run(scene_from_text(head(substeps) +
                                   "gravity: [{sine: {amplitude: 3, frequency: 0.5}}, 0, [[0, 0], [1, -9.81]]]\nbodies:\n"
                                   "  - {shape: {sphere: {radius: 0.1}}, mass: 2, force: [0, {table: [[0, 1], [1, 5]]}, 0],\n"
                                   "     torque: [0, 0, {sine: {amplitude: 0.1, frequency: 1}}]}\n"
                                   "  - {shape: {sphere: {radius: 0.1}}, mass: 2, position: [5, 0, 0]}\n"));
    const double inertia = 0.4 * 2 * 0.01, w = 2 * M_PI;
    for (int k = 1; k <= 150 * substeps; ++k) {
      run.step();
      const double t = k * run.h(), up = std::min(t, 1.0), after = t - up;
      const Vec3 by_gravity(3 / M_PI * (1 - std::cos(M_PI * t)), 0, -9.81 * (0.5 * up * up + after));
      const Vec3 by_force(0, 0.5 * (up + 2 * up * up + 5 * after), 0);  // over 2 kg
      EXPECT_LT((run.velocity(0) - by_gravity - by_force).norm(), 1e-11) << t;
      EXPECT_LT((run.velocity(1) - by_gravity).norm(), 1e-11) << t;
      EXPECT_NEAR(run.state(0).angular_velocity.z(), 0.1 / w * (1 - std::cos(w * t)) / inertia, 1e-9) << t;
    }
  }
}

// On a floor that is tilted faster and faster, as gravity's direction says, a box begins to slide where a t = mu g: from then on
// its velocity is the integral of a t - mu g.
TEST_P(MotionInTime, ABoxSlidesWhereGravityHasTurnedFarEnough) {
  const double a = 4, mu = 0.3, g = 9.81, start = mu * g / a;
  Experiment run(scene_from_text(head(2) + "gravity: [[[0, 0], [2, 8]], 0, -9.81]\nmaterials: {m: {friction: 0.3}}\nbodies:\n"
                                           "  - {shape: {plane: {normal: [0, 0, 1]}}}\n"
                                           "  - {shape: {box: {size: [0.4, 0.4, 0.1]}}, mass: 3, position: [0, 0, 0.05]}\n"));
  run.seconds(0.95 * start);
  EXPECT_LT(std::abs(run.velocity(1).x()), 1e-3);
  EXPECT_LT(std::abs(run.position(1).x()), 1e-3);
  run.seconds(1.5 - 0.95 * start);
  const double slid = std::round(0.95 * start / 0.01) * 0.01 + std::round((1.5 - 0.95 * start) / 0.01) * 0.01 - start;
  EXPECT_NEAR(run.velocity(1).x(), 0.5 * a * slid * slid, 0.01 * a * slid);
}

// A body that is pressed on a floor by a force that lets go at 0.5 s, and pulls it up from then on.
TEST_P(MotionInTime, AForceLetsGo) {
  Experiment run(scene_from_text(head() + "bodies:\n  - {shape: {plane: {normal: [0, 0, 1]}}}\n"
                                          "  - {shape: {sphere: {radius: 0.1}}, mass: 1, position: [0, 0, 0.1],\n"
                                          "     force: [0, 0, {table: [[0, -50], [0.5, 14.81]], between: steps}]}\n"));
  run.seconds(0.5);
  EXPECT_NEAR(run.position(1).z(), 0.1, 1e-4);
  EXPECT_LT(run.velocity(1).norm(), 1e-3);
  run.seconds(0.5);
  EXPECT_NEAR(run.velocity(1).z(), 5 * 0.5, 1e-3);
}

INSTANTIATE_TEST_SUITE_P(Solvers, MotionInTime, testing::Values("accelerated_jacobi", "gauss_seidel"));

}  // namespace unibody::small_worlds::motion_in_time_test
