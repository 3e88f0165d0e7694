// Momentum and angular momentum of free cloths over hundreds of steps: what is exact, and what the scheme takes at which order.
#include <gtest/gtest.h>

#include <cmath>

#include "small_worlds.hpp"

namespace unibody::small_worlds::cloth_momentum_test {

namespace {

const char* const springs = "links: {stiffness: 200}";
const char* const damped_springs = "links: {stiffness: 200, damping: 0.1}";
const char* const stiff_links = "links: {}";
const char* const damped_links = "links: {damping: 0.1}";
const char* const fabric =
    "membrane: {youngs_modulus: 2.0e4, poissons_ratio: 0.3}\n    bending: {model: dihedral, stiffness: 0.001}";
const char* const damped_fabric =
    "membrane: {youngs_modulus: 2.0e4, poissons_ratio: 0.3, damping: 0.1}\n"
    "    bending: {model: dihedral, stiffness: 0.001, damping: 0.1}";

const Vec3 drift(0.1, 0.2, 0.3);  // m/s

// 1 m x 1 m in the plane z = 0, its middle at the origin, moving with these velocities beside the drift.
template <class Velocity>
Experiment free_cloth(const char* model, double h, Velocity&& velocity) {
  Scene scene = scene_from_text(
      "gravity: [0, 0, 0]\ncloths:\n  - grid: {size: [1, 1], nodes: [8, 8]}\n    mass: 2\n    thickness: 0.01\n    " +
      std::string(model) + "\n");
  scene.time.frame = h, scene.solver.tolerance = 0;
  Experiment run(std::move(scene));
  World& world = run.world();
  for (std::size_t i = 0; i < world.homes; ++i) world.velocity[i] = drift + velocity(world.position[i]);
  return run;
}

struct Losses {
  double momentum = 0;          // largest change over the run, relative
  double angular_momentum = 0;  // change over the run, relative
  double torque = 0;            // largest of a step that the step's own terms do not explain, over L
};

// For 0.8 s. With x' = x + h v' and inner impulses that turn nothing about x', a step of implicit Euler changes the angular
// momentum by L' - L = h sum m v' x v.
Losses shake(const char* model, double h) {
  Experiment run = free_cloth(model, h, [](const Vec3& x) -> Vec3 {
    return Vec3(0.5, 0.3, 1).cross(x) + 0.3 * Vec3(std::sin(5 * x.x()), std::cos(4 * x.y()), std::sin(3 * x.x() + 4 * x.y()));
  });
  const World& world = run.world();
  const Vec3 p = run.momentum(), L = run.angular_momentum();
  Losses losses;
  for (int k = 0; k < static_cast<int>(0.8 / h + 0.5); ++k) {
    const auto velocity = world.velocity;
    const Vec3 before = run.angular_momentum();
    run.step();
    Vec3 change = Vec3::Zero();
    for (std::size_t i = 0; i < world.homes; ++i) change += h * world.properties[i].mass * world.velocity[i].cross(velocity[i]);
    losses.torque = std::max(losses.torque, (run.angular_momentum() - before - change).norm() / L.norm());
    losses.momentum = std::max(losses.momentum, (run.momentum() - p).norm() / p.norm());
  }
  losses.angular_momentum = (run.angular_momentum() - L).norm() / L.norm();
  return losses;
}

}  // namespace

// Momentum stays to round-off: each impulse is given to one end and taken from the other. Angular momentum is lost at first order
// in the step, as implicit Euler loses it. Beyond that a step's impulses, applied along the directions of their iterations, turn
// the cloth by second order in the step.
TEST(ClothMomentum, ShakingLosesWhatTheStepExplains) {
  for (const char* model : {springs, stiff_links, fabric}) {
    const Losses coarse = shake(model, 0.008), fine = shake(model, 0.004);
    for (const Losses& losses : {coarse, fine}) EXPECT_LT(losses.momentum, 1e-13) << model;
    EXPECT_LT(coarse.angular_momentum, 0.02) << model;
    EXPECT_NEAR(std::log2(coarse.angular_momentum / fine.angular_momentum), 1, 0.1) << model;
    EXPECT_LT(coarse.torque, 1e-5) << model;
    EXPECT_GT(std::log2(coarse.torque / fine.torque), 1.9) << model;
  }
}

// A cloth that turns in its plane, with damping and without: omega' = -h omega^3 of the implicit step, so that
// omega = omega0 / sqrt(1 + 2 h omega0^2 t), and nothing to the damping, whose rows see no rigid motion. To the square of what is
// lost, and to what springs yield to the centrifugal force.
TEST(ClothMomentum, DampingLeavesRotationAndTranslationAlone) {
  const double omega = 2, seconds = 1.6;
  for (const double h : {0.016, 0.004})
    for (const char* model : {springs, damped_springs, stiff_links, damped_links, fabric, damped_fabric}) {
      Experiment run = free_cloth(model, h, [&](const Vec3& x) -> Vec3 { return omega * Vec3::UnitZ().cross(x); });
      const Vec3 p = run.momentum(), L = run.angular_momentum();
      const int steps = static_cast<int>(seconds / h + 0.5);
      for (int k = 0; k < steps; ++k) {
        run.step();
        ASSERT_LT((run.momentum() - p).norm(), 1e-13 * p.norm()) << model << ' ' << k;
      }
      Vec3 middle = Vec3::Zero();
      for (const Vec3& x : run.world().position) middle += x / static_cast<double>(run.world().homes);
      EXPECT_LT((middle - steps * h * drift).norm(), 1e-12) << model;
      const double lost = 1 - 1 / std::sqrt(1 + 2 * h * omega * omega * seconds);
      EXPECT_NEAR((L - run.angular_momentum()).norm() / L.norm(), lost, 0.02 * lost) << model << ' ' << h;
    }
}

}  // namespace unibody::small_worlds::cloth_momentum_test
