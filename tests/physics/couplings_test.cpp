// Couplings of joints against closed forms: gears, a planetary gear, a rack, a screw, and their bits on any number of ranks.
#include <gtest/gtest.h>

#include <cmath>

#include "small_worlds.hpp"

namespace unibody::small_worlds::couplings_test {

namespace {

constexpr double g = 9.81;

std::string settings(const std::string& solver, double step, const std::string& more = "") {
  return "solver: {name: " + solver + more + "}\ntime: {frame: " + std::to_string(step) + "}\n";
}

std::string wheel(const std::string& name, double mass, double radius, double x, const std::string& more = "") {
  return "  - {name: " + name + ", shape: {cylinder: {radius: " + std::to_string(radius) +
         ", length: 0.1}}, mass: " + std::to_string(mass) + ", position: [" + std::to_string(x) + ", 0, 0]" + more + "}\n";
}

std::string axle(const std::string& name, const std::string& of, const std::string& on, double x) {
  return "  - {name: " + name + ", type: hinge, bodies: [" + of + ", " + on + "], anchor: [" + std::to_string(x) +
         ", 0, 0], axis: [0, 0, 1]}\n";
}

class CouplingOf : public testing::TestWithParam<const char*> {};

}  // namespace

// Two wheels, the second twice as large and turning half as fast the other way: a torque M on the first gives it
// M / (I_1 + I_2 / 4). They turn through many turns and stay in step.
TEST_P(CouplingOf, GearsAccelerateByTheirInertias) {
  const std::string solver = GetParam();
  for (const char* joints : {", joints: iterative", ", joints: direct"}) {
    Experiment run(scene_from_text("gravity: [0, 0, 0]\nbodies:\n" + wheel("small", 1, 0.2, 0, ", torque: [0, 0, 0.6]") +
                                   wheel("large", 4, 0.4, 1) + "joints:\n" + axle("first", "small", "world", 0) +
                                   axle("second", "large", "world", 1) +
                                   "couplings:\n  - {joints: [first, second], ratio: -2}\n" + settings(solver, 0.0025, joints)));
    const double of_small = 0.5 * 1 * 0.04, of_large = 0.5 * 4 * 0.16, rate = 0.6 / (of_small + of_large / 4);
    double turned = 0, turned_large = 0, before = 0, before_large = 0;
    for (int k = 0; k < 1600; ++k) {
      run.step();
      const auto states = run.simulation->joint_states();
      turned += std::remainder(states[0].coordinate - before, 2 * M_PI), before = states[0].coordinate;
      turned_large += std::remainder(states[1].coordinate - before_large, 2 * M_PI), before_large = states[1].coordinate;
      ASSERT_NEAR(turned, -2 * turned_large, 1e-3) << k;
    }
    EXPECT_GT(turned, 2 * 2 * M_PI);
    EXPECT_NEAR(run.state(0).angular_velocity.z(), 4 * rate, 1e-3 * 4 * rate) << solver << joints;
    EXPECT_NEAR(run.state(1).angular_velocity.z(), -2 * rate, 1e-3 * 2 * rate) << solver << joints;
  }
}

// A sun that is held, a carrier and a planet of the sun's size: as the carrier turns once, the planet turns twice. The planet is
// hinged to the carrier, so that its angle there is that of the carrier against the sun: a coupling that only saw the planet and
// the sun would not know the carrier's turn. Free of forces the kinetic energy stays.
TEST_P(CouplingOf, APlanetTurnsTwiceAsItsCarrier) {
  Experiment run(
      scene_from_text("gravity: [0, 0, 0]\nbodies:\n  - {name: carrier, shape: {box: {size: [1, 0.1, 0.1]}}, mass: 1, "
                      "angular_velocity: [0, 0, 2]}\n" +
                      wheel("planet", 0.5, 0.2, 0.4, ", velocity: [0, 0.8, 0], angular_velocity: [0, 0, 4]") + "joints:\n" +
                      axle("arm", "carrier", "world", 0) + axle("pin", "planet", "carrier", 0.4) +
                      "couplings:\n  - {joints: [pin, arm], ratio: 1}\n" + settings(GetParam(), 0.002)));
  const double start = run.kinetic_energy();
  run.seconds(2);
  EXPECT_NEAR(run.state(0).angular_velocity.z(), 2, 0.01);
  EXPECT_NEAR(run.state(1).angular_velocity.z(), 4, 0.02);
  EXPECT_NEAR(run.kinetic_energy() / start, 1, 0.01);
  const auto states = run.simulation->joint_states();
  EXPECT_NEAR(std::remainder(states[1].coordinate - states[0].coordinate, 2 * M_PI), 0, 1e-5);
}

// A rack of mass m falls along its slider and turns a pinion of radius r: a = g m / (m + I / r^2).
TEST_P(CouplingOf, ARackFallsWithItsPinion) {
  Experiment run(
      scene_from_text("bodies:\n" + wheel("pinion", 3, 0.2, 0, ", orientation: {axis: [1, 0, 0], angle: 90}") +
                      "  - {name: rack, shape: {box: {size: [0.1, 0.1, 1]}}, mass: 2, position: [0.25, 0, 0], collide: "
                      "{with: []}}\njoints:\n"
                      "  - {name: axle, type: hinge, bodies: [pinion, world], anchor: [0, 0, 0], axis: [0, 1, 0]}\n"
                      "  - {name: guide, type: slider, bodies: [rack, world], anchor: [0.25, 0, 0], axis: [0, 0, 1]}\n"
                      "couplings:\n  - {joints: [guide, axle], ratio: -0.2}\n" +
                      settings(GetParam(), 0.004)));
  run.seconds(1);
  const double a = g * 2 / (2 + 0.5 * 3);
  EXPECT_NEAR(run.velocity(1).z(), -a, 1e-3 * a);
  EXPECT_NEAR(run.state(0).angular_velocity.y(), a / 0.2, 1e-3 * a / 0.2);
}

// A screw of pitch p turns in a nut that slides: a motor of torque M pushes with 2 pi M / p, and moves the screw along.
TEST_P(CouplingOf, AScrewLiftsWhatItsPitchSays) {
  const double pitch = 0.05, torque = 0.2;
  const auto run_with = [&](double mass) {
    Experiment run(
        scene_from_text("bodies:\n" + wheel("screw", 1, 0.05, 0) +
                        "  - {name: nut, shape: {box: {size: [0.2, 0.2, 0.1]}}, mass: " + std::to_string(mass) +
                        ", position: [0, 0, 0.5]}\njoints:\n  - {name: turn, type: hinge, bodies: [screw, world], anchor: "
                        "[0, 0, 0], axis: [0, 0, 1], motor: {speed: 20, max_torque: " +
                        std::to_string(torque) +
                        "}}\n  - {name: way, type: slider, bodies: [nut, world], anchor: [0, 0, 0.5], axis: [0, 0, 1]}\n"
                        "couplings:\n  - {joints: [way, turn], ratio: " +
                        std::to_string(pitch / (2 * M_PI)) + "}\n" + settings(GetParam(), 0.005)));
    run.seconds(1);
    return run.velocity(1).z();
  };
  const double held = 2 * M_PI * torque / pitch / g, reach = pitch / (2 * M_PI);  // kg, m
  const double of_screw = 0.5 * 1 * 0.05 * 0.05 / (reach * reach);                // kg, its inertia seen by the nut
  for (const double mass : {0.9 * held, 1.1 * held}) {
    const double a = (held - mass) * g / (mass + of_screw);
    EXPECT_NEAR(run_with(mass), a, 1e-3 * std::abs(a)) << mass;
  }
  EXPECT_NEAR(run_with(0.5 * held), 20 * reach, 1e-3);
}

INSTANTIATE_TEST_SUITE_P(Solvers, CouplingOf, testing::Values("accelerated_jacobi", "gauss_seidel"),
                         [](const auto& each) { return std::string(each.param); });

// A train of gears on all ranks: neighbours share their wheels.
TEST(RanksCoupling, StepsHaveTheSameBits) {
  int rank = 0;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  for (const std::string solver : {"accelerated_jacobi", "gauss_seidel"}) {
    std::string text = "gravity: [0, 0, 0]\nbodies:\n", joints = "joints:\n", couplings = "couplings:\n";
    for (int k = 0; k < 12; ++k) {
      const std::string name = "w" + std::to_string(k), on = "a" + std::to_string(k);
      text += wheel(name, 1 + 0.1 * k, 0.2, 0.5 * k, k == 0 ? ", torque: [0, 0, 1]" : "");
      joints += axle(on, name, "world", 0.5 * k);
      if (k > 0) couplings += "  - {joints: [" + on + ", a" + std::to_string(k - 1) + "], ratio: -0.8}\n";
    }
    const std::string scene = text + joints + couplings + settings(solver, 0.01);
    Experiment alone(scene_from_text(scene)), together(scene_from_text(scene), MPI_COMM_WORLD);
    alone.steps(40), together.steps(40);
    World& world = together.world();
    for (std::size_t i = 0; i < world.homes; ++i) {
      EXPECT_EQ(world.angular_velocity[i], alone.state(world.id[i]).angular_velocity) << solver << ' ' << world.id[i];
      EXPECT_EQ(world.orientation[i].coeffs(), alone.state(world.id[i]).orientation.coeffs()) << solver << ' ' << world.id[i];
    }
    EXPECT_GT(alone.state(0).angular_velocity.norm(), 0.1);
  }
}

}  // namespace unibody::small_worlds::couplings_test
