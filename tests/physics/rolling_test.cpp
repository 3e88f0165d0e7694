// Rolling and spinning friction against closed forms: how fast a ball slows down, stops and stays, on the level and on a slope.
#include <gtest/gtest.h>

#include <cmath>

#include "small_worlds.hpp"

namespace unibody::small_worlds::rolling_test {

namespace {

const char* const solver_list[] = {"accelerated_jacobi", "jacobi", "gauss_seidel"};
constexpr double g = 9.81, radius = 0.1, mass = 2;

// A ball (I = 2/5 m r^2) that touches a plane, inclined by `slope` (rad) through gravity.
Experiment ball_on_plane(const std::string& solver, const std::string& friction, double slope, const Vec3& v, const Vec3& w) {
  const auto vector = [](const Vec3& x) {
    return "[" + std::to_string(x.x()) + ", " + std::to_string(x.y()) + ", " + std::to_string(x.z()) + "]";
  };
  return Experiment(
      scene_from_text("gravity: " + vector(g * Vec3(std::sin(slope), 0, -std::cos(slope))) + "\nmaterials: {a: {friction: 0.8, " +
                      friction + "}}\nsolver: {iterations: 800, tolerance: 0, name: " + solver +
                      "}\ntime: {frame: 0.01}\nbodies:\n  - {shape: {plane: {normal: [0, 0, 1]}}}\n" +
                      "  - {shape: {sphere: {radius: 0.1}}, mass: 2, position: [0, 0, 0.1], velocity: " + vector(v) +
                      ", angular_velocity: " + vector(w) + "}\n"));
}

}  // namespace

// Friction F and the torque mu_r m g: m a = -F, I alpha = F r - mu_r m g, a = r alpha; so a = -mu_r g / (r (1 + I / m r^2)).
TEST(Rolling, ABallSlowsDownStopsAndStays) {
  constexpr double coefficient = 0.004, a = coefficient * g / (radius * 1.4), h = 0.01;
  for (const char* solver : solver_list)
    for (const double along : {0.0, 0.7}) {
      const Vec3 way(std::cos(along), std::sin(along), 0);
      Experiment run = ball_on_plane(solver, "rolling_friction: 0.004", 0, 0.3 * way, Vec3(0, 0, 1).cross(way) * 0.3 / radius);
      double v = 0.3, x = 0;
      for (int k = 1; k <= 150; ++k) {
        run.step();
        v = std::max(0.0, v - a * h), x += h * v;
        ASSERT_NEAR((run.velocity(1) - v * way).norm(), 0, 1e-6) << solver << ' ' << k;
        ASSERT_NEAR((run.position(1) - x * way).head<2>().norm(), 0, 1e-6) << solver << ' ' << k;
      }
      EXPECT_EQ(v, 0) << "such a run does not stop";
      EXPECT_LT(run.last.residual, 1e-6) << solver;
    }
}

// I dw/dt = -mu_s m g.
TEST(Rolling, ASpinningBallStops) {
  constexpr double coefficient = 0.0015, rate = coefficient * mass * g / (0.4 * mass * radius * radius), h = 0.01;
  for (const char* solver : solver_list) {
    Experiment run = ball_on_plane(solver, "spinning_friction: 0.0015", 0, Vec3::Zero(), Vec3(0, 0, 3));
    double w = 3;
    for (int k = 1; k <= 100; ++k) {
      run.step();
      w = std::max(0.0, w - rate * h);
      ASSERT_NEAR(run.state(1).angular_velocity.z(), w, 1e-6) << solver << ' ' << k;
    }
    EXPECT_EQ(w, 0) << "such a run does not stop";
    EXPECT_LT(run.position(1).head<2>().norm(), 1e-9) << solver;
  }
}

// It stays where tan(slope) < mu_r / r; above, (1 + I / m r^2) a = g sin(slope) - mu_r g cos(slope) / r.
TEST(Rolling, OnASlopeItStaysOrRolls) {
  const double least = std::atan(0.01 / radius);
  for (const char* solver : solver_list) {
    Experiment stays = ball_on_plane(solver, "rolling_friction: 0.01", 0.95 * least, Vec3::Zero(), Vec3::Zero());
    stays.seconds(2);
    EXPECT_LT(stays.position(1).head<2>().norm(), 1e-6) << solver;
    const double slope = 1.5 * least, a = g * (std::sin(slope) - std::cos(slope) * 0.01 / radius) / 1.4;
    Experiment rolls = ball_on_plane(solver, "rolling_friction: 0.01", slope, Vec3::Zero(), Vec3::Zero());
    rolls.seconds(1);
    EXPECT_NEAR(rolls.velocity(1).x() / a, 1, 1e-5) << solver;
    Experiment freely = ball_on_plane(solver, "rolling_friction: 0", slope, Vec3::Zero(), Vec3::Zero());
    freely.seconds(1);
    EXPECT_NEAR(freely.velocity(1).x() / (g * std::sin(slope) / 1.4), 1, 1e-5) << solver;
  }
}

// Between two free bodies: the torque is mutual, so that angular momentum stays while the spins even out.
TEST(Rolling, TheTorqueIsMutual) {
  for (const char* solver : solver_list) {
    Experiment run(scene_from_text(std::string(R"(
gravity: [0, 0, 0]
materials: {a: {friction: 0, spinning_friction: 0.01, rolling_friction: 0.01}}
bodies:
  - {shape: {sphere: {radius: 0.1}}, mass: 1, position: [-0.1, 0, 0], force: [5, 0, 0], angular_velocity: [4, 0, 2]}
  - {shape: {sphere: {radius: 0.2}}, mass: 3, position: [0.2, 0, 0], force: [-5, 0, 0]}
solver: {iterations: 400, tolerance: 0, name: )") +
                                   solver + "}\n"));
    const Vec3 before = run.angular_momentum();
    const double energy = run.kinetic_energy();
    run.steps(40);
    EXPECT_LT((run.angular_momentum() - before).norm(), 1e-10) << solver;
    EXPECT_LT(run.kinetic_energy(), 0.99 * energy) << solver;
    EXPECT_LT((run.state(0).angular_velocity - run.state(1).angular_velocity).norm(), 1e-6) << solver;
  }
}

// At the defaults, below the threshold tan(slope) = coefficient / radius: what each step leaves undone does not add up.
TEST(Rolling, WhatIsHeldIsAtRestAtTheDefaults) {
  for (const char* solver : {"accelerated_jacobi", "gauss_seidel"})
    for (const int substeps : {1, 4})
      for (const double share : {0.5, 0.9, 0.98}) {
        const double coefficient = 0.01, slope = std::atan(share * coefficient / radius);
        Experiment run(scene_from_text(
            "time: {substeps: " + std::to_string(substeps) + "}\nsolver: {name: " + solver + "}\ngravity: [" +
            std::to_string(g * std::sin(slope)) + ", 0, " + std::to_string(-g * std::cos(slope)) +
            "]\nmaterials: {m: {friction: 0.5, rolling_friction: 0.01}}\nbodies:\n  - {shape: {plane: {normal: [0, 0, 1]}}}\n  - "
            "{shape: {sphere: {radius: 0.1}}, mass: 1, position: [0, 0, 0.1]}\n"));
        run.seconds(8);
        EXPECT_LT(run.position(1).head<2>().norm(), 1e-3) << share << ' ' << solver << ' ' << substeps;
        EXPECT_LT(run.velocity(1).norm(), 1e-6) << share << ' ' << solver << ' ' << substeps;
      }
}

}  // namespace unibody::small_worlds::rolling_test
