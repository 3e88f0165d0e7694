// Springs and dampers about hinges and along sliders, against implicit Euler and closed forms.
#include <gtest/gtest.h>

#include <cmath>

#include "small_worlds.hpp"

namespace unibody::small_worlds::joint_springs_test {

namespace {

constexpr double h = 0.01;
const char* const solver_list[] = {"accelerated_jacobi", "jacobi", "gauss_seidel"};

std::string settings(const std::string& solver, const std::string& more = "") {
  return "solver: {name: " + solver + ", iterations: 50, tolerance: 0" + more + "}\ntime: {frame: " + std::to_string(h) + "}\n";
}

JointState joint(const Experiment& run) { return run.simulation->joint_states()[0]; }

// A wheel of 2 kg and radius 0.5 m about a hinge of the world along its axis z.
std::string wheel(const std::string& spring, const std::string& more = "") {
  return "gravity: [0, 0, 0]\nbodies: [{name: wheel, shape: {cylinder: {radius: 0.5, length: 0.1}}, mass: 2" + more +
         "}]\njoints: [{type: hinge, bodies: [wheel, world], anchor: [0, 0, 0], axis: [0, 0, 1], spring: {" + spring + "}}]\n";
}
constexpr double inertia = 0.5 * 2 * 0.25;

std::string cart(const std::string& spring, const std::string& more = "") {
  return "gravity: [0, 0, 0]\nbodies: [{name: cart, shape: {box: {size: [0.2, 0.2, 0.2]}}, mass: 2" + more +
         "}]\njoints: [{type: slider, bodies: [cart, world], anchor: [0, 0, 0], axis: [1, 0, 0], spring: {" + spring + "}}]\n";
}

// Implicit Euler of x'' = -(k (x - rest) + c x') / m.
struct Oscillator {
  double m, k, c, rest, x = 0, v = 0;
  void step() {
    v = (v - h * k / m * (x - rest)) / (1 + h * c / m + h * h * k / m);
    x += h * v;
  }
};

}  // namespace

TEST(JointSpring, ASliderOscillatesAsImplicitEulerSays) {
  for (const std::string solver : solver_list)
    for (const auto& [k, c] : {std::pair(80.0, 0.0), std::pair(80.0, 5.0), std::pair(0.0, 5.0)}) {
      const std::string spring = "stiffness: " + std::to_string(k) + ", damping: " + std::to_string(c);
      Experiment run(scene_from_text(cart(spring + (k > 0 ? ", rest: 0.3" : ""), ", velocity: [1, 0, 0]") + settings(solver)));
      Oscillator exact{2, k, c, k > 0 ? 0.3 : 0, 0, 1};
      for (int i = 0; i < 200; ++i) {
        run.step(), exact.step();
        ASSERT_NEAR(run.position(0).x(), exact.x, 1e-9) << solver << ' ' << k << ' ' << c << ' ' << i;
        ASSERT_NEAR(run.velocity(0).x(), exact.v, 1e-9) << solver << ' ' << k << ' ' << c << ' ' << i;
      }
      EXPECT_NEAR(joint(run).spring, -k * (exact.x - exact.rest) - c * exact.v, 1e-5) << solver << ' ' << k << ' ' << c;
    }
}

// The same of a hinge, whose turn within a step is 2 atan(h w / 2) rather than h w: off by that.
TEST(JointSpring, AHingeOscillatesAsImplicitEulerSays) {
  for (const std::string solver : solver_list)
    for (const auto& [k, c] : {std::pair(10.0, 0.0), std::pair(10.0, 1.0), std::pair(0.0, 1.0)}) {
      const std::string spring = "stiffness: " + std::to_string(k) + ", damping: " + std::to_string(c);
      Experiment run(
          scene_from_text(wheel(spring + (k > 0 ? ", rest: 30" : ""), ", angular_velocity: [0, 0, 1]") + settings(solver)));
      Oscillator exact{inertia, k, c, k > 0 ? M_PI / 6 : 0, 0, 1};
      for (int i = 0; i < 100; ++i) {
        run.step(), exact.step();
        ASSERT_NEAR(joint(run).coordinate, exact.x, 2e-4) << solver << ' ' << k << ' ' << c << ' ' << i;
      }
      EXPECT_NEAR(joint(run).spring, -k * (exact.x - exact.rest) - c * exact.v, 5e-3) << solver << ' ' << k << ' ' << c;
    }
}

// A torque M turns a spring of stiffness k by M / k, whatever the joints' solver; across the end of the angle's range, too.
TEST(JointSpring, RestsWhereTheTorqueSays) {
  for (const std::string solver : solver_list)
    for (const char* joints : {", joints: iterative", ", joints: direct"}) {
      Experiment run(
          scene_from_text(wheel("stiffness: 40, damping: 4, rest: 170", ", torque: [0, 0, 20]") + settings(solver, joints)));
      run.seconds(8);
      const double expected = std::remainder(170 * M_PI / 180 + 0.5, 2 * M_PI);
      EXPECT_NEAR(joint(run).coordinate, expected, 1e-5) << solver << joints;
      EXPECT_NEAR(joint(run).spring, -20, 1e-3) << solver << joints;
    }
}

// Between two free bodies it takes no momentum, and their relative motion is that of the reduced mass.
TEST(JointSpring, BetweenTwoBodiesKeepsMomentum) {
  for (const std::string solver : solver_list) {
    Experiment run(scene_from_text(
        "gravity: [0, 0, 0]\nbodies:\n  - {name: a, shape: {box: {size: [0.2, 0.2, 0.2]}}, mass: 1, velocity: [1, 0, 0]}\n"
        "  - {name: b, shape: {box: {size: [0.2, 0.2, 0.2]}}, mass: 3, position: [-1, 0, 0]}\n"
        "joints: [{type: slider, bodies: [a, b], anchor: [0, 0, 0], axis: [1, 0, 0], spring: {stiffness: 50}}]\n" +
        settings(solver)));
    Oscillator exact{0.75, 50, 0, 0, 0, 1};
    for (int i = 0; i < 100; ++i) {
      run.step(), exact.step();
      ASSERT_NEAR(run.position(0).x() - run.position(1).x() - 1, exact.x, 1e-8) << solver << ' ' << i;
    }
    EXPECT_NEAR((run.momentum() - Vec3(1, 0, 0)).norm(), 0, 1e-12) << solver;
  }
}

// Of a stiff one, too.
TEST(JointSpring, DefaultsConverge) {
  for (const std::string solver : {"accelerated_jacobi", "gauss_seidel"}) {
    Experiment run(
        scene_from_text(cart("stiffness: 2000, damping: 3", ", velocity: [1, 0, 0]") + "solver: {name: " + solver + "}\n"));
    for (int i = 0; i < 50; ++i) EXPECT_TRUE(run.step().converged) << solver << ' ' << i;
  }
}

}  // namespace unibody::small_worlds::joint_springs_test
