// What joints do beside closing, against closed forms: springs and dampers, motors and friction of sliders and hinges, and the
// motion that a universal joint passes on.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "small_worlds.hpp"

namespace unibody::small_worlds::joint_drives_test {

namespace {

constexpr double h = 0.01;
const char* const solver_list[] = {"accelerated_jacobi", "jacobi", "gauss_seidel"};

std::string settings(const std::string& solver, int iterations) {
  return "solver: {name: " + solver + ", iterations: " + std::to_string(iterations) +
         ", tolerance: 0}\ntime: {frame: " + std::to_string(h) + "}\n";
}

JointState joint(const Experiment& run, std::size_t i = 0) { return run.simulation->joint_states()[i]; }

// Implicit Euler of x'' = -k (x + rho x'), k = 1 / (compliance inertia): both sides at the step's end.
struct Oscillator {
  double k, rho, x, v;
  void step() {
    v = (v - h * k * x) / (1 + h * (h + rho) * k);
    x += h * v;
  }
};

}  // namespace

// Each step divides x'^2 + k x^2, more or less, by 1 + h (h + rho) k: the damping shows beside the step's own from the first on.
TEST(JointDrive, ADampedSpringOscillatesAsImplicitEulerSays) {
  for (const char* solver : solver_list)
    for (const double rho : {0.0, 0.03, 0.4}) {  // s; beyond 2 / sqrt(k) = 0.28 it creeps
      Experiment run(
          scene_from_text("gravity: [0, 0, 0]\nbodies: [{name: bob, shape: {sphere: {radius: 0.1}}, mass: 2}]\n"
                          "joints: [{type: ball, bodies: [bob, world], anchor: [0, 0, 0], compliance: 0.01, damping: " +
                          std::to_string(rho) + "}]\n" + settings(solver, 50)));
      run.world().velocity[0] = Vec3(0.6, 0, 0.8);
      Oscillator exact{1 / (0.01 * 2), rho, 0, 1};
      for (int k = 0; k < 200; ++k) {
        run.step(), exact.step();
        ASSERT_LT((run.position(0) - exact.x * Vec3(0.6, 0, 0.8)).norm(), 1e-10) << solver << ' ' << rho << ' ' << k;
        ASSERT_LT((run.velocity(0) - exact.v * Vec3(0.6, 0, 0.8)).norm(), 1e-9) << solver << ' ' << rho << ' ' << k;
      }
    }
}

// Implicit Euler of a bob of mass m on a rope: of its extension x the part s = max(0, x) is that of a spring and a damper, which
// pull with f = (s + rho (s - s_before) / h) / E where that is more than 0.
struct Rope {
  double m, E, rho, x, v;
  double force = 0;
  void step(double gravity) {
    const double free = v + h * gravity, before = std::max(0.0, x);
    force = std::max(0.0, ((x + h * free) * (1 + rho / h) - before * rho / h) / (E + h * (h + rho) / m));
    v = free - h / m * force;
    x += h * v;
  }
};

// The bob falls freely, is caught, and where little damps it is thrown back into the slack, again and again; at last it hangs m g
// E below the rope's length.
TEST(JointDrive, ARopeIsADampedSpringAndDoesNothingSlack) {
  const double m = 3, g = 9.81;
  for (const char* level : {"position", "velocity"})
    for (const char* solver : solver_list)
      for (const double E : {0.0, 1e-3})
        for (const double rho : {0.0, 0.03, 0.4}) {
          if (E == 0 && rho == 0) continue;  // a rope that neither stretches nor damps is tested with the other stiff joints
          const std::string what = std::string(level) + ' ' + solver + ' ' + std::to_string(E) + ' ' + std::to_string(rho);
          Experiment run(
              scene_from_text("bodies: [{name: bob, shape: {sphere: {radius: 0.1}}, mass: 3, position: [0, 0, -0.7]}]\njoints: "
                              "[{type: rope, bodies: "
                              "[bob, world], points: [[0, 0, -0.6], [0, 0, 0]], length: 0.9, compliance: " +
                              std::to_string(E) + ", damping: " + std::to_string(rho) + "}]\n" +
                              settings(std::string(solver) + ", level: " + level, 50)));
          Rope exact{m, E, rho, -0.3, 0};
          int slack_and_parting = 0, taut = 0;
          for (int k = 0; k < 200; ++k) {
            run.step(), exact.step(g);
            ASSERT_NEAR(-run.position(0).z() - 1, exact.x, 1e-10) << what << ' ' << k;
            ASSERT_NEAR(-run.velocity(0).z(), exact.v, 1e-8) << what << ' ' << k;
            ASSERT_NEAR(joint(run).force.z(), exact.force, 1e-6) << what << ' ' << k;
            slack_and_parting += exact.x < 0 && exact.v > 1, taut += exact.force > 0;
          }
          EXPECT_GT(slack_and_parting, 10) << what;  // where c + rho dc/dt > 0 all the same
          EXPECT_GT(taut, 20) << what;
          if (rho < 0.1) continue;
          run.steps(1200);
          EXPECT_NEAR(joint(run).drift, m * g * E, 1e-8) << what;
          EXPECT_NEAR(joint(run).force.z(), m * g, 1e-4) << what;
        }
}

// A spring between two bodies is a fifth longer at the start than at rest. Their distance must follow the implicit Euler steps of
// an oscillator that has their reduced mass, while the spring pulls and while it pushes. Their centre of mass must not move.
TEST(JointDrive, ASpringPullsAndPushes) {
  const double m = 2.0 * 3 / 5, E = 1e-3;
  for (const char* level : {"position", "velocity"})
    for (const char* solver : solver_list)
      for (const double rho : {0.0, 0.002, 0.4}) {
        const std::string what = std::string(level) + ' ' + solver + ' ' + std::to_string(rho);
        Experiment run(scene_from_text(
            "gravity: [0, 0, 0]\nbodies: [{name: a, shape: {sphere: {radius: 0.1}}, mass: 2}, {name: b, shape: "
            "{particle: {radius: 0.1}}, mass: 3, position: [0.72, 0, 0.96]}]\njoints: [{type: spring, bodies: [a, b], "
            "points: [[0, 0, 0], [0.72, 0, 0.96]], length: 1, compliance: 0.001, damping: " +
            std::to_string(rho) + "}]\n" + settings(std::string(solver) + ", level: " + level, 50)));
        const Vec3 centre = 0.6 * run.position(1);
        double x = 0.2, v = 0, least = 1;
        for (int k = 0; k < 200; ++k) {
          const double force = (x + (h + rho) * v) / (E + h * (h + rho) / m);
          v -= h / m * force, x += h * v;
          run.step();
          ASSERT_NEAR((run.position(1) - run.position(0)).norm(), 1 + x, 1e-9) << what << ' ' << k;
          ASSERT_LT((0.4 * run.position(0) + 0.6 * run.position(1) - centre).norm(), 1e-12) << what << ' ' << k;
          ASSERT_NEAR(joint(run).force.norm(), std::abs(force), 1e-6) << what << ' ' << k;
          least = std::min(least, x);
        }
        EXPECT_LT(least, rho == 0 ? -0.05 : 0.2) << what;
        EXPECT_NEAR(joint(run).coordinate, 1 + x, 1e-9) << what;
        EXPECT_NEAR(joint(run).drift, std::abs(x), 1e-9) << what;
      }
}

// Without compliance it is a rod: two bodies turn about each other at its length, and it bears m w^2 l, with the reduced mass m;
// two that fall on it stand off.
TEST(JointDrive, ARodKeepsItsLength) {
  for (const char* solver : solver_list) {
    Experiment run(scene_from_text(
        "gravity: [0, 0, 0]\nbodies: [{name: a, shape: {particle: {radius: 0.1}}, mass: 2, velocity: [0, 0.6, 0]}, "
        "{name: b, shape: {particle: {radius: 0.1}}, mass: 3, position: [1, 0, 0], velocity: [0, -0.4, 0]}]\n"
        "joints: [{type: spring, bodies: [a, b], points: [[0, 0, 0], [1, 0, 0]]}]\n" +
        settings(solver, 50)));
    for (int k = 0; k < 50; ++k) {
      run.step();
      ASSERT_NEAR((run.position(1) - run.position(0)).norm(), 1, 1e-9) << solver << ' ' << k;
    }
    EXPECT_NEAR(joint(run).force.norm(), 1.2, 0.06) << solver;  // implicit steps slow it, by (h w)^2 / 2 each
    Experiment pressed(scene_from_text(
        "bodies: [{name: a, shape: {particle: {radius: 0.1}}, mass: 2, position: [0, 0, 1]}, {name: ground, shape: "
        "{sphere: {radius: 0.1}}, motion: fixed}]\njoints: [{type: spring, bodies: [a, ground], points: [[0, 0, 1], "
        "[0, 0, 0]]}]\n" +
        settings(solver, 50)));
    pressed.steps(20);
    EXPECT_NEAR(pressed.position(0).z(), 1, 1e-9) << solver;
    EXPECT_NEAR(joint(pressed).force.z(), 2 * 9.81, 1e-6) << solver;
  }
}

// The same of a turn, about a principal axis and so small that it is its sine.
TEST(JointDrive, ADampedTorsionSpringOscillatesAsImplicitEulerSays) {
  const double inertia = 3 * (0.4 * 0.4 + 0.2 * 0.2) / 12, compliance = 0.2;
  for (const char* solver : solver_list)
    for (const double rho : {0.0, 0.03, 0.4}) {
      Experiment run(
          scene_from_text("gravity: [0, 0, 0]\nbodies: [{name: wheel, shape: {box: {size: [0.4, 0.1, 0.2]}}, mass: 3}]\n"
                          "joints: [{type: fixed, bodies: [wheel, world], anchor: [0, 0, 0], turning_compliance: 0.2, "
                          "damping: " +
                          std::to_string(rho) + "}]\n" + settings(solver, 50)));
      run.world().angular_velocity[0] = Vec3(0, 1e-4, 0);
      Oscillator exact{1 / (compliance * inertia), rho, 0, 1e-4};
      for (int k = 0; k < 200; ++k) {
        run.step(), exact.step();
        ASSERT_NEAR(run.state(0).angular_velocity.y(), exact.v, 1e-10) << solver << ' ' << rho << ' ' << k;
        ASSERT_NEAR(2 * run.state(0).orientation.y(), exact.x, 1e-11) << solver << ' ' << rho << ' ' << k;
      }
    }
}

// A bar held at its end turns by torque times compliance: m g l cos(a) C, the row being the sine of a.
TEST(JointDrive, ACantileverTurnsByItsTorqueTimesItsCompliance) {
  const double weight = 2 * 9.81, arm = 0.25;
  for (const char* solver : solver_list)
    for (const double compliance : {1e-4, 0.1}) {
      Experiment run(
          scene_from_text("bodies: [{name: bar, shape: {box: {size: [0.5, 0.1, 0.1]}}, mass: 2, position: [0.25, 0, 0]}]\n"
                          "joints: [{type: fixed, bodies: [bar, world], anchor: [0, 0, 0], damping: 0.2, "
                          "turning_compliance: " +
                          std::to_string(compliance) + "}]\n" + settings(solver, 50)));
      run.steps(350);
      const double angle = std::atan(weight * arm * compliance);
      EXPECT_NEAR(joint(run).turn / angle, 1, angle * angle / 20 + 1e-6) << solver << ' ' << compliance;
      EXPECT_NEAR(std::atan2(-run.position(0).z(), run.position(0).x()) / angle, 1, 1e-6) << solver << ' ' << compliance;
      EXPECT_LT(joint(run).drift, 1e-9) << solver;
      EXPECT_NEAR(joint(run).force.z() / weight, 1, 1e-6) << solver;
      EXPECT_NEAR(joint(run).torque.y() / (-weight * arm * std::cos(angle)), 1, 1e-6) << solver << ' ' << compliance;
    }
}

// v = F t / m up to the motor's speed, then nothing to do.
TEST(JointDrive, ASlidersMotorReachesItsSpeedWithItsForce) {
  for (const char* solver : solver_list) {
    Experiment run(
        scene_from_text("gravity: [0, 0, 0]\nbodies: [{name: cart, shape: {box: {size: [0.4, 0.2, 0.2]}}, mass: 2}]\n"
                        "joints: [{type: slider, bodies: [cart, world], anchor: [0, 0, 0.1], axis: [0.6, 0.8, 0], "
                        "motor: {speed: 1.5, max_force: 3}}]\n" +
                        settings(solver, 100)));
    for (int k = 1; k <= 150; ++k) {
      run.step();
      const double t = k * h, v = std::min(1.5, 3 * t / 2);
      ASSERT_LT((run.velocity(0) - v * Vec3(0.6, 0.8, 0)).norm(), 1e-8) << solver << ' ' << k;
      ASSERT_NEAR(joint(run).motor, t < 1 + h / 2 ? 3 : 0, 1e-5) << solver << ' ' << k;
    }
  }
}

// The way to its place: all of the force F up to where half of it can still brake, v^2 = F d / m at the distance d, which is
// a third of the way; and never beyond its end. There it gives what holds it.
TEST(JointDrive, ASlidersMotorReachesItsPlace) {
  const double way = 0.6, most = std::sqrt(2 * 3 * way / (3 * 2.0));
  for (const char* solver : solver_list)
    for (const double weight : {0.0, 1.0}) {
      Experiment run(scene_from_text("gravity: [" + std::to_string(-weight / 2) +
                                     ", 0, 0]\n"
                                     "bodies: [{name: cart, shape: {box: {size: [0.4, 0.2, 0.2]}}, mass: 2}]\n"
                                     "joints: [{type: slider, bodies: [cart, world], anchor: [0, 0, 0], axis: [1, 0, 0], "
                                     "motor: {offset: 0.6, max_force: 3}}]\n" +
                                     settings(solver, 100)));
      double fastest = 0, farthest = 0;
      for (int k = 0; k < 400; ++k) {
        run.step();
        fastest = std::max(fastest, run.velocity(0).x()), farthest = std::max(farthest, run.position(0).x());
      }
      if (weight == 0) {
        EXPECT_NEAR(fastest / most, 1, 0.03) << solver;
      }
      EXPECT_LT(farthest, way + 1e-6) << solver;
      EXPECT_NEAR(run.position(0).x(), way, 1e-6) << solver;
      EXPECT_NEAR(joint(run).coordinate, way, 1e-6) << solver;
      EXPECT_NEAR(joint(run).motor, weight, 1e-5) << solver;
    }
}

// A wheel slows by T / I until it stands, in a step that takes only what is left.
// However far the wheel turns in a step, it is where its speed says.
TEST(JointDrive, AHingesMotorTurnsAsFastAsItsSpeed) {
  for (const char* solver : solver_list)
    for (const double speed : {3.0, -40.0, 90.0}) {  // rad/s
      Experiment run(
          scene_from_text("gravity: [0, 0, 0]\nbodies: [{name: wheel, shape: {cylinder: {radius: 0.1, length: 0.1}}, mass: 2}]\n"
                          "joints: [{type: hinge, bodies: [wheel, world], anchor: [0, 0, 0], axis: [0, 0, 1], "
                          "motor: {max_torque: 1.0e+6, speed: " +
                          std::to_string(speed) + "}}]\n" + settings(solver, 50)));
      for (int k = 1; k <= 100; ++k) {
        run.step();
        ASSERT_NEAR(std::remainder(joint(run).coordinate - k * h * speed, 2 * std::numbers::pi), 0, 1e-6) << solver << speed << k;
      }
    }
}

TEST(JointDrive, AHingesFrictionSlowsAWheel) {
  const double inertia = 3 * (0.4 * 0.4 + 0.2 * 0.2) / 12, torque = 0.2;
  for (const char* solver : solver_list) {
    Experiment run(
        scene_from_text("gravity: [0, 0, 0]\nbodies: [{name: wheel, shape: {box: {size: [0.4, 0.1, 0.2]}}, mass: 3}]\n"
                        "joints: [{type: hinge, bodies: [wheel, world], anchor: [0, 0, 0], axis: [0, 1, 0], "
                        "friction: 0.2}]\n" +
                        settings(solver, 100)));
    run.world().angular_velocity[0] = Vec3(0, -2, 0);
    for (int k = 1; k <= 60; ++k) {
      run.step();
      const double w = std::max(0.0, 2 - torque / inertia * k * h);  // stands after 0.5 s
      ASSERT_NEAR(run.state(0).angular_velocity.y(), -w, 1e-9) << solver << ' ' << k;
      ASSERT_NEAR(joint(run).friction, k <= 50 ? torque : 0, 1e-7) << solver << ' ' << k;
    }
  }
}

// Two shafts that meet at an angle b: tan(second's angle) = cos(b) tan(first's), turn after turn.
TEST(JointDrive, AUniversalJointPassesOnTheMotionOfCardansShafts) {
  const double bend = std::numbers::pi / 6, c = std::cos(bend), s = std::sin(bend);
  const auto vector = [](double x, double y) { return "[" + std::to_string(x) + ", " + std::to_string(y) + ", 0]"; };
  for (const char* solver : solver_list) {
    Scene scene = scene_from_text(
        "gravity: [0, 0, 0]\nbodies:\n  - {name: driving, shape: {box: {size: [0.8, 0.1, 0.1]}}, mass: 1, position: [-0.5, 0, "
        "0]}\n"
        "  - {name: driven, shape: {box: {size: [0.8, 0.1, 0.1]}}, mass: 1, position: " +
        vector(0.5 * c, 0.5 * s) +
        ", orientation: {axis: [0, 0, 1], angle: 30}}\njoints:\n"
        "  - {type: hinge, bodies: [driving, world], anchor: [-0.9, 0, 0], axis: [1, 0, 0], motor: {speed: 4, max_torque: 1}}\n"
        "  - {type: hinge, bodies: [driven, world], anchor: " +
        vector(0.9 * c, 0.9 * s) + ", axis: " + vector(c, s) +
        "}\n"
        "  - {type: universal, bodies: [driving, driven], anchor: [0, 0, 0], axis: [0, 0, 1], second_axis: " +
        vector(-s, c) + "}\n" + settings(solver, 100));
    Experiment run(std::move(scene));
    double total = 0, before = 0, lag = 0;
    for (int k = 0; k < 350; ++k) {
      run.step();
      const double first = joint(run, 0).coordinate, second = joint(run, 1).coordinate;
      total += std::remainder(first - before, 2 * std::numbers::pi), before = first;
      const double expected = std::atan2(c * std::sin(first), std::cos(first));
      ASSERT_NEAR(std::remainder(second - expected, 2 * std::numbers::pi), 0, 1e-5) << solver << ' ' << k;
      lag = std::max(lag, std::abs(std::remainder(second - first, 2 * std::numbers::pi)));
    }
    EXPECT_GT(total, 4 * std::numbers::pi) << solver;
    EXPECT_NEAR(lag, std::atan((1 - c) / (2 * std::sqrt(c))), 1e-3) << solver << ": such shafts do not turn alike";
  }
}

}  // namespace unibody::small_worlds::joint_drives_test
