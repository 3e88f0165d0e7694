// Bridges of liquid, against closed forms of their force, their work and their reach.
#include "step/liquid.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "small_worlds.hpp"

namespace unibody::small_worlds::liquid_test {

namespace {

constexpr double g = 9.81, radius = 1e-3, volume = 1e-11, tension = 0.072, density = 2500;
const double mass = density * 4 / 3 * M_PI * radius * radius * radius, reach = std::cbrt(volume);

std::string number(double x) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.17g", x);
  return text.data();
}

std::string settings(const std::string& solver, double frame, const std::string& material) {
  return "solver: {name: " + solver + "}\ntime: {frame: " + number(frame) + "}\nmaterials: {wet: {friction: 0.3, " + material +
         "}}\n";
}

const std::string wet = "liquid_volume: 1.0e-11";

// A ball of 1 mm above (or, with its gap negative, deep in) the plane z = 0, or below it where the plane is a ceiling.
std::string ball_at(double z, const Vec3& velocity, double heavier = 1) {
  return "  - {name: ball, shape: {sphere: {radius: 0.001}}, material: wet, mass: " + number(heavier * mass) +
         ", position: [0, 0, " + number(z) + "], velocity: [" + number(velocity.x()) + ", 0, " + number(velocity.z()) + "]}\n";
}
const std::string ceiling = "bodies:\n  - {name: ceiling, shape: {plane: {normal: [0, 0, -1]}}, material: wet}\n";
const std::string ground = "bodies:\n  - {name: ground, shape: {plane: {normal: [0, 0, 1]}}, material: wet}\n";

class LiquidOf : public testing::TestWithParam<const char*> {};

}  // namespace

TEST(Liquid, TheLawIsThatOfWillettAndOthers) {
  const double R = 2e-3, V = 1e-9, angle = 0.4, S = 3e-4;
  const double apart = S * std::sqrt(R / V);
  EXPECT_NEAR(bridge_force(R / 2, S, V, tension, angle),
              2 * M_PI * R * tension * std::cos(angle) / (1 + 1.05 * apart + 2.5 * apart * apart), 1e-12);
  EXPECT_NEAR(bridge_force(R / 2, -1e-6, V, tension, angle), 2 * M_PI * R * tension * std::cos(angle), 1e-12);
  EXPECT_NEAR(rupture_distance(V, angle), 1.2e-3, 1e-12);
}

// A ball hangs from a ceiling by 4 pi R gamma cos(theta), and another one from it by half of that.
TEST_P(LiquidOf, ABridgeCarriesWhatItPullsBy) {
  for (const double angle : {0.0, 40.0})
    for (const double share : {0.97, 1.03}) {
      const double pull = 4 * M_PI * radius * tension * std::cos(angle * M_PI / 180), heavier = share * pull / (mass * g);
      const std::string material = wet + ", contact_angle: " + number(angle);
      Experiment one(scene_from_text(ceiling + ball_at(-radius, Vec3::Zero(), heavier) + settings(GetParam(), 0.001, material)));
      Experiment two(scene_from_text(
          "bodies:\n  - {name: held, shape: {sphere: {radius: 0.001}}, material: wet, motion: fixed, position: [0, 0, 0]}\n" +
          ball_at(-2 * radius, Vec3::Zero(), heavier / 2) + settings(GetParam(), 0.001, material)));
      one.seconds(0.2), two.seconds(0.2);
      for (const double fallen : {-radius - one.position(1).z(), -2 * radius - two.position(1).z()}) {
        EXPECT_EQ(fallen < 1e-6, share < 1) << GetParam() << angle << " " << fallen;
        EXPECT_EQ(fallen > 0.01, share > 1) << GetParam() << angle << " " << fallen;
      }
    }
}

// There is no bridge before two bodies have touched; then it reaches as far as its volume allows.
TEST_P(LiquidOf, ABridgeIsThereOnceBodiesHaveTouched) {
  const std::string none = "gravity: [0, 0, 0]\n" + settings(GetParam(), 1e-4, wet);
  Experiment waits(scene_from_text(ground + ball_at(radius + 0.5 * reach, Vec3::Zero()) + none));
  waits.steps(100);
  EXPECT_EQ(waits.velocity(1).norm(), 0) << GetParam();
  EXPECT_EQ(count_bridges(*waits.simulation), 0) << GetParam();
  Experiment touched(scene_from_text(ground + ball_at(radius, {0, 0, 0.02}) + none));
  touched.steps(100);
  EXPECT_EQ(count_bridges(*touched.simulation), 1) << GetParam();  // too slow to come off: it lies on the ground again
  EXPECT_NEAR(touched.position(1).z(), radius, 1e-6) << GetParam();
}

// Work against the bridge on the way to its rupture: the ball that comes off is slower by it, and goes on at that speed.
TEST_P(LiquidOf, ABallThatComesOffHasDoneTheWorkOfTheBridge) {
  double work = 0;
  constexpr int parts = 10000;
  for (int k = 0; k < parts; ++k) work += bridge_force(radius, (k + 0.5) * reach / parts, volume, tension, 0) * reach / parts;
  const double speed = 2 * std::sqrt(2 * work / mass);
  Experiment run(scene_from_text("gravity: [0, 0, 0]\n" + ground + ball_at(radius, {0, 0, speed}) +
                                 settings(GetParam(), reach / speed / 400, wet)));
  run.steps(380);
  EXPECT_EQ(count_bridges(*run.simulation), 1) << GetParam();
  run.steps(300);
  run.simulation->detect();
  EXPECT_EQ(count_bridges(*run.simulation), 0) << GetParam();
  EXPECT_NEAR(0.5 * mass * std::pow(run.velocity(1).z(), 2), 3 * work, 0.01 * work) << GetParam();
  const double after = run.velocity(1).z();
  run.steps(10);
  EXPECT_EQ(run.velocity(1).z(), after) << GetParam();
}

// The cone of friction has its tip at the pull: on a wall a ball that is too sluggish to roll stays where friction times the pull
// bears its weight.
TEST_P(LiquidOf, WhatHangsOnAWallIsHeldByFriction) {
  for (const double share : {0.9, 1.1}) {
    const double pull = 4 * M_PI * radius * tension, weight = share * 0.3 * pull;
    Experiment run(
        scene_from_text("bodies:\n  - {name: wall, shape: {plane: {normal: [1, 0, 0]}}, material: wet}\n"
                        "  - {name: ball, shape: {sphere: {radius: 0.001}}, material: wet, inertia: [1, 1, 1], mass: " +
                        number(weight / g) + ", position: [0.001, 0, 0]}\n" + settings(GetParam(), 0.001, wet)));
    run.seconds(0.1);
    EXPECT_EQ(std::abs(run.position(1).z()) < 1e-6, share < 1) << GetParam() << run.position(1).z();
    EXPECT_EQ(run.position(1).z() < -1e-4, share > 1) << GetParam() << run.position(1).z();
  }
}

INSTANTIATE_TEST_SUITE_P(Solvers, LiquidOf, testing::Values("accelerated_jacobi", "gauss_seidel"),
                         [](const auto& each) { return std::string(each.param); });

// A wet pile that is thrown about: the same bridges and bits on any number of ranks, with bodies that change their ranks.
TEST(RanksLiquid, StepsHaveTheSameBits) {
  int ranks = 1;
  MPI_Comm_size(MPI_COMM_WORLD, &ranks);
  for (const std::string solver : {"accelerated_jacobi", "gauss_seidel"}) {
    const std::string text =
        "bodies:\n  - {name: ground, shape: {plane: {normal: [0, 0, 1]}}, material: wet}\n"
        "  - {name: grains, lattice: {count: 64, columns: [4, 4], spacing: [0.00203, 0.00203, 0.00203], height: 0.0011, "
        "jitter: 1.0e-5, seed: 2}, shape: {sphere: {radius: 0.001}}, density: 2500, material: wet}\n"
        "  - {name: hit, shape: {sphere: {radius: 0.002}}, density: 2500, material: wet, position: [-0.009, 0, 0.004], "
        "velocity: [1, 0, 0]}\n" +
        settings(solver, 0.0005, wet);
    Experiment alone(scene_from_text(text)), together(scene_from_text(text), MPI_COMM_WORLD);
    alone.steps(15), together.steps(15);
    EXPECT_GT(count_bridges(*alone.simulation), 20) << solver;
    std::vector<int> home;
    for (std::size_t i = 0; i < together.world().homes; ++i) home.push_back(static_cast<int>(together.world().id[i] / 3) % ranks);
    together.simulation->move_homes(home);
    alone.steps(15), together.steps(15);
    EXPECT_EQ(count_bridges(*alone.simulation), count_bridges(*together.simulation)) << solver;
    const World& world = together.world();
    for (std::size_t i = 0; i < world.homes; ++i)
      EXPECT_EQ(world.position[i], alone.position(world.id[i])) << solver << ' ' << world.id[i];
  }
}

}  // namespace unibody::small_worlds::liquid_test
