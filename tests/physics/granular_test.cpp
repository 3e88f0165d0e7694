// Particles alone: spheres that do not turn, as a granular material.
#include <gtest/gtest.h>

#include <cmath>

#include "small_worlds.hpp"

namespace unibody::small_worlds::granular_test {

namespace {

constexpr double g = 9.81, radius = 0.05;

// A square pyramid of layers of n x n, (n - 1) x (n - 1), ... grains, each in the hollow of four below it.
std::string pyramid(int n, double friction) {
  std::string points;
  for (int layer = 0; layer < n; ++layer)
    for (int i = 0; i < n - layer; ++i)
      for (int j = 0; j < n - layer; ++j) {
        const double first = radius * (layer - n + 1);
        points += (points.empty() ? "[" : ", [") + std::to_string(first + 2 * radius * i) + ", " +
                  std::to_string(first + 2 * radius * j) + ", " + std::to_string(radius * (1 + layer * std::sqrt(2))) + "]";
      }
  return "materials: {sand: {friction: " + std::to_string(friction) +
         "}}\nbodies:\n  - {shape: {plane: {normal: [0, 0, 1]}}}\n  - points: [" + points +
         "]\n    shape: {particle: {radius: 0.05}}\n    mass: 0.2\n";
}

double widest(const Experiment& run) {
  double worst = 0;
  for (std::size_t i = 0; i < run.simulation->world.homes; ++i)
    worst = std::max(worst, run.simulation->world.position[i].head<2>().lpNorm<Eigen::Infinity>());
  return worst;
}

}  // namespace

// Friction holds the heap, without it the lowest grains are pressed aside and it falls down.
TEST(Granular, FrictionHoldsAHeapOfParticles) {
  for (const char* solver : {"accelerated_jacobi", "gauss_seidel"})
    for (const double friction : {0.8, 0.0}) {
      Scene scene = scene_from_text(pyramid(4, friction));
      scene.solver.name = solver, scene.solver.iterations = 200;
      Experiment run(std::move(scene));
      const double foot = widest(run), top = run.position(30).z();
      run.seconds(1);
      if (friction > 0) {
        EXPECT_NEAR(run.position(30).z(), top, 0.02 * radius) << solver;
        EXPECT_NEAR(widest(run), foot, 0.02 * radius) << solver;
        EXPECT_LT(run.kinetic_energy(), 1e-6) << solver;
        double weight = 0;
        for (Id id = 1; id <= 16; ++id) weight += run.normal_force(0, id);
        EXPECT_NEAR(weight / (30 * 0.2 * g), 1, 0.01) << solver;
      } else {
        EXPECT_LT(run.position(30).z(), top - radius) << solver;
        EXPECT_GT(widest(run), foot + 2 * radius) << solver;
      }
    }
}

// A particle on a slope rubs, and does not roll: it stays below the angle of friction, and slides beyond it.
TEST(Granular, AGrainSticksOrSlides) {
  const double mu = 0.5;
  for (const double factor : {0.95, 1.05}) {
    Scene scene = scene_from_text(
        "materials: {sand: {friction: 0.5}}\nbodies:\n  - {shape: {plane: {normal: [0, 0, 1]}}}\n"
        "  - {shape: {particle: {radius: 0.05}}, mass: 1, position: [0, 0, 0.05]}\n");
    const double angle = std::atan(factor * mu);
    scene.gravity = g * Vec3(std::sin(angle), 0, -std::cos(angle));
    Experiment run(std::move(scene));
    run.steps(10);
    const double before = run.velocity(1).x(), gained = g * (std::sin(angle) - mu * std::cos(angle)) * 100 * run.h();
    run.steps(100);
    if (factor < 1) {
      EXPECT_LT(run.velocity(1).norm(), 1e-9);
    } else {
      EXPECT_NEAR(run.velocity(1).x() - before, gained, 1e-6 * gained);
    }
  }
}

// On a pinned sheet, a plane and a leaning wall nothing in the scene turns, and no room is taken for it; what stands keeps its
// orientation. A box that turns, if only by itself, takes room for all.
TEST(Granular, ParticlesAloneHaveNoRotations) {
  const std::string grains =
      "bodies:\n  - points: [[0.2, 0.1, 0.055], [-0.2, 0.1, 0.055]]\n    shape: {particle: {radius: 0.05}}\n    mass: 1\n";
  const std::string sheet =
      "cloths:\n  - {grid: {size: [1, 1], nodes: [2, 2]}, mass: 1, thickness: 0.01, pins: [{within: {min: [-1, -1, -1], max: [1, "
      "1, "
      "1]}}]}\n";
  const std::string plane = "  - shape: {plane: {normal: [0, 0, 1]}}\n    position: [0, 0, -9]\n";
  const std::string turning =
      "  - shape: {box: {size: [1, 1, 1]}}\n    motion: kinematic\n    angular_velocity: [1, 0, 0]\n    position: [0, 0, -5]\n";
  for (const std::string& more : {std::string(), plane, plane + turning}) {
    Experiment run(scene_from_text(grains + more + sheet));
    const bool turns = more.size() > plane.size();
    EXPECT_EQ(run.world().has_rotations, turns);
    EXPECT_EQ(run.world().orientation.empty() && run.world().angular_velocity.empty(), !turns);
    run.steps(50);
    for (const Id id : {0, 1}) EXPECT_LT((run.position(id) - Vec3(id == 0 ? 0.2 : -0.2, 0.1, 0.055)).norm(), 1e-5);
  }
}

// Between a plane that leans and a box turned by 45 degrees, a grain falls into the groove and touches both.
TEST(Granular, WhatStandsIsTurnedWhereNothingTurns) {
  Experiment run(scene_from_text(R"(
materials: {glass: {friction: 0}}
bodies:
  - shape: {plane: {normal: [0.6, 0, 0.8]}}
  - shape: {box: {size: [1, 1, 1]}}
    motion: fixed
    position: [1, 0, -0.75]
    orientation: {axis: [0, 1, 0], angle: 45}
  - {shape: {particle: {radius: 0.05}}, mass: 1, position: [0.6, 0, 0]}
)"));
  EXPECT_FALSE(run.world().has_rotations);
  run.seconds(3);
  const Vec3 at = run.position(2), side = Vec3(-1, 0, 1) / std::sqrt(2), middle(1, 0, -0.75);
  EXPECT_NEAR(Vec3(0.6, 0, 0.8).dot(at), radius, 1e-6);
  EXPECT_NEAR(side.dot(at - middle), 0.5 + radius, 1e-6);
  EXPECT_LT(run.kinetic_energy(), 1e-9);
}

// 22 layers are more than five sweeps of the velocity stage reach through: the pile lands on its contacts as on a spring. What
// leaks from the positions must not pump that: unchecked, it sways for seconds at 0.003 to 0.1 J a sphere. 1.7e-3 J is
// what the spheres of a pile at rest are allowed.
TEST(Granular, APileDeeperThanFewSweepsReachDoesNotSway) {
  Scene scene = scene_from_text(
      "gravity: [0, 0, -9.8]\nmaterials: {glass: {friction: 0.3}}\nbodies:\n  - container: {size: [1.5, 1.5]}\n"
      "  - lattice: {count: 5000, columns: [13, 13], spacing: [0.11, 0.11, 0.11], height: 0.2, jitter: 0.004}\n"
      "    shape: {sphere: {radius: 0.05}}\n    mass: 1\n");
  scene.solver.name = "gauss_seidel", scene.solver.iterations = 10, scene.solver.tolerance = 0;
  Experiment run(std::move(scene));
  run.steps(150);
  double energy = 0;
  for (int step = 0; step < 50; ++step) {
    run.steps(1);
    energy += run.kinetic_energy() / 5000 / 50;
  }
  EXPECT_LT(energy, 1.7e-3);
}

}  // namespace unibody::small_worlds::granular_test
