// Scenes that repeat themselves: closed forms across their borders, and motions that no place of the borders may change.
#include <gtest/gtest.h>

#include <cmath>

#include "core/errors.hpp"
#include "small_worlds.hpp"

namespace unibody::small_worlds::periodic_test {

namespace {

constexpr double g = 9.81;
constexpr int steps_alike = 20;

std::string head(const std::string& solver, int substeps, const std::string& periodic, const std::string& material,
                 const std::string& gravity = "[0, 0, 0]") {
  return "time: {substeps: " + std::to_string(substeps) + "}\nsolver: {iterations: 400, tolerance: 1.0e-9, name: " + solver +
         "}\nperiodic: " + periodic + "\ngravity: " + gravity + "\nmaterials: {m: {" + material + "}}\nbodies:\n";
}
std::string entry(const std::string& shape, const std::string& mass, const std::string& more) {
  return "  - {shape: {" + shape + "}, " + mass + ", " + more + "}\n";
}
std::string list(const Vec3& v) {
  return "[" + std::to_string(v.x()) + ", " + std::to_string(v.y()) + ", " + std::to_string(v.z()) + "]";
}

std::size_t contact_points(const Experiment& run) { return run.simulation->contacts.points.size(); }

// Boxes and balls that fall on a plane, which reach over the borders along x and y.
std::string pile(const std::string& solver, const std::string& periodic, int copies = 1, double length = 1.2) {
  std::string text =
      head(solver, 1, periodic, "friction: 0.5", "[0.5, 0.2, -9.81]") + "  - {shape: {plane: {normal: [0, 0, 1]}}}\n";
  text.replace(text.find("400, tolerance: 1.0e-9"), 22,
               "50, acceleration: none, tolerance: 0");  // as many iterations of all, and no momentum that restarts
  const std::string shapes[] = {"sphere: {radius: 0.11}", "box: {size: [0.14, 0.12, 0.13]}"};
  const std::string axes[] = {"[1, 0, 0]", "[0, 0.6, 0.8]", "[0.6, 0, -0.8]"};
  for (int k = 0; k < 64; ++k)
    for (int copy = 0; copy < copies; ++copy) {
      const Vec3 place{0.3 * (k % 4) + 0.01 * (k % 7) + copy * length, 0.3 * (k / 4 % 4) + 0.013 * (k % 5),
                       0.15 + 0.3 * (k / 16)};
      text += entry(shapes[k % 2], "mass: 1",
                    "position: " + list(place) + ", velocity: " + list({0.5 - 0.1 * (k % 9), 0.1 * (k % 11) - 0.5, 0}) +
                        ", orientation: {axis: " + axes[k % 3] + ", angle: " + std::to_string(37 * k) + "}");
    }
  return text;
}

}  // namespace

class PeriodicOf : public testing::TestWithParam<std::tuple<const char*, int>> {};

TEST_P(PeriodicOf, TwoBodiesMeetAcrossABorder) {
  const auto [solver, substeps] = GetParam();
  const std::string shapes[] = {"sphere: {radius: 0.1}", "box: {size: [0.2, 0.2, 0.2]}",
                                "hull: {points: [[-0.1, -0.1, -0.1], [0.1, -0.1, -0.1], [-0.1, 0.1, -0.1], [0.1, 0.1, -0.1], "
                                "[-0.1, -0.1, 0.1], [0.1, -0.1, 0.1], [-0.1, 0.1, 0.1], [0.1, 0.1, 0.1]]}"};
  for (const std::string& shape : shapes)
    for (int axis = 0; axis < 3; ++axis)
      for (const double restitution : {0.0, 1.0}) {
        const std::string name(1, "xyz"[axis]);
        const Vec3 e = Vec3::Unit(axis);
        Experiment run(scene_from_text(
            head(solver, substeps, "{" + name + ": [-1, 1]}", "friction: 0.3, restitution: " + std::to_string(restitution)) +
            entry(shape, "mass: 1", "position: " + list(0.7 * e) + ", velocity: " + list(e)) +
            entry(shape, "mass: 3", "position: " + list(-0.8 * e))));
        run.seconds(0.272);  // they touch at 0.3 s
        EXPECT_NEAR(run.velocity(0).dot(e), 1, 1e-12);
        run.seconds(0.1);
        const double after = restitution > 0 ? -0.5 : 0.25, other = restitution > 0 ? 0.5 : 0.25;
        EXPECT_NEAR(run.velocity(0).dot(e), after, 1e-6) << shape << name << restitution;
        EXPECT_NEAR(run.velocity(1).dot(e), other, 1e-6) << shape << name << restitution;
        EXPECT_LT(run.state(0).angular_velocity.norm() + run.state(1).angular_velocity.norm(), 1e-6);
      }
}

// A box that slides down passes the border again and again; a row of others before it is at rest in the tilted cell.
TEST_P(PeriodicOf, ABoxSlidesThroughManyCells) {
  const auto [solver, substeps] = GetParam();
  const double slope = 0.5, mu = 0.3;
  Experiment run(scene_from_text(
      head(solver, substeps, "{x: [0, 1]}", "friction: 0.3", list(g * Vec3(std::sin(slope), 0, -std::cos(slope)))) +
      "  - {shape: {plane: {normal: [0, 0, 1]}}}\n" +
      entry("box: {size: [0.2, 0.2, 0.2]}", "mass: 2", "position: [0.5, 0, 0.1]")));
  run.seconds(1.6);
  EXPECT_NEAR(run.velocity(1).x(), 1.6 * g * (std::sin(slope) - mu * std::cos(slope)), 1e-5);
  EXPECT_GT(run.position(1).x(), 3);  // it goes on counting
}

// Two courses of bricks, the upper ones over the joints of the lower ones: each rests on two, which touch it from 0.005 to 0.12 m
// off its middle. Statics does not say how these share its weight, but that neither bears less than 0.005 / 0.125 of it: else the
// brick would tip over the other.
TEST_P(PeriodicOf, AWallWithoutEnds) {
  const auto [solver, substeps] = GetParam();
  const auto brick = [](double x, double z) {
    return entry("box: {size: [0.24, 0.12, 0.1]}", "mass: 2", "position: " + list({x, 0, z}));
  };
  std::string text = head(solver, substeps, "{x: [0.05, 1.05]}", "friction: 0.6", "[0, 0, -9.81]") +
                     "  - {shape: {plane: {normal: [0, 0, 1]}}}\n";
  for (int k = 0; k < 4; ++k) text += brick(0.25 * k, 0.05) + brick(0.25 * k + 0.125, 0.15);
  Experiment run(scene_from_text(text));
  run.seconds(0.8);
  double on_ground = 0;
  for (int k = 0; k < 4; ++k) {
    const Id lower = 1 + 2 * k, upper = lower + 1, next = 1 + 2 * ((k + 1) % 4);
    on_ground += run.normal_force(0, lower);
    EXPECT_NEAR(run.normal_force(std::min(lower, upper), std::max(lower, upper)) +
                    run.normal_force(std::min(next, upper), std::max(next, upper)),
                2 * g, 1e-2)
        << k;
    EXPECT_GT(run.normal_force(std::min(next, upper), std::max(next, upper)), 2 * g * 0.005 / 0.125) << k;
    EXPECT_NEAR((run.position(upper) - Vec3(0.25 * k + 0.125, 0, 0.15)).norm(), 0, 1e-4) << k;
  }
  EXPECT_NEAR(on_ground, 8 * 2 * g, 1e-2);
}

// Tiles that are flush across the border, too, are one floor.
TEST_P(PeriodicOf, ATiledFloorHasNoSeamAtTheBorder) {
  const auto [solver, substeps] = GetParam();
  std::string text = head(solver, substeps, "{x: [0, 2]}", "friction: 0", "[0, 0, -9.81]");
  for (int k = 0; k < 4; ++k)
    text += entry("box: {size: [0.5, 1, 0.2]}", "motion: fixed", "position: " + list({0.25 + 0.5 * k, 0, -0.1}));
  Experiment run(
      scene_from_text(text + entry("box: {size: [0.3, 0.3, 0.3]}", "mass: 1", "position: [0.5, 0, 0.15], velocity: [5, 0, 0]")));
  for (int k = 0; k < 2 / run.h(); ++k) {
    run.step();
    ASSERT_NEAR(run.velocity(4).x(), 5, 1e-6) << k;
    ASSERT_NEAR(run.position(4).z(), 0.15, 1e-4) << k;
  }
}

TEST_P(PeriodicOf, WhatIsFastGoesThroughNothingAtTheBorder) {
  const auto [solver, substeps] = GetParam();
  for (const char* shape : {"sphere: {radius: 0.03}", "box: {size: [0.06, 0.06, 0.06]}"}) {
    Experiment run(scene_from_text(head(solver, substeps, "{x: [0, 4]}", "friction: 0") +
                                   entry("box: {size: [0.02, 0.5, 0.5]}", "motion: fixed", "position: [0.1, 0, 0]") +
                                   entry(shape, "mass: 1", "position: [2, 0, 0], velocity: [40, 0, 0]")));
    run.seconds(0.32);
    EXPECT_NEAR(run.position(1).x(), 4.06, 2e-3) << shape;
    EXPECT_NEAR(run.velocity(1).norm(), 0, 1e-6) << shape;
  }
}

// Three balls of which the middle one is at the border: the speed goes to the last one.
TEST_P(PeriodicOf, ACradleAcrossTheBorder) {
  const auto [solver, substeps] = GetParam();
  const auto ball = [](double x, double v) {
    return entry("sphere: {radius: 0.1}", "mass: 1", "position: " + list({x, 0, 0}) + ", velocity: " + list({v, 0, 0}));
  };
  Experiment run(scene_from_text(head(solver, substeps, "{x: [0, 2]}", "friction: 0, restitution: 1") + ball(1.5, 2) +
                                 ball(1.95, 0) + ball(0.2, 0)));
  run.seconds(0.32);
  EXPECT_NEAR(run.velocity(0).x(), 0, 1e-9);
  EXPECT_NEAR(run.velocity(1).x(), 0, 1e-9);
  EXPECT_NEAR(run.velocity(2).x(), 2, 1e-9);
}

// A gas without walls keeps its momentum and its energy.
TEST_P(PeriodicOf, AGasKeepsItsMomentum) {
  const auto [solver, substeps] = GetParam();
  std::string text = head(solver, substeps, "{x: [0, 1], y: [0, 1], z: [0, 1]}", "friction: 0, restitution: 1");
  for (int k = 0; k < 64; ++k)
    text += entry("sphere: {radius: 0.06}", "mass: 1",
                  "position: " + list({0.25 * (k % 4), 0.25 * (k / 4 % 4), 0.25 * (k / 16)}) +
                      ", velocity: " + list({std::sin(1.3 * k), std::cos(2.1 * k), std::sin(0.7 * k + 1)}));
  Experiment run(scene_from_text(text));
  const Vec3 momentum = run.momentum();
  const double energy = run.kinetic_energy();
  std::int64_t impacts = 0;
  for (int k = 0; k < 2 / run.h(); ++k) run.step(), impacts += run.last.impacts;
  EXPECT_GT(impacts, 100);
  EXPECT_LT((run.momentum() - momentum).norm(), 1e-10);
  EXPECT_NEAR(run.kinetic_energy(), energy, 1e-6 * energy);
}

// Two balls on a rod go through the border, and meet a third one behind it, as they do in a scene without borders.
TEST_P(PeriodicOf, AJointReachesAcrossTheBorder) {
  const auto [solver, substeps] = GetParam();
  const auto scene = [&](const std::string& place, bool repeats) {
    std::string text = head(solver, substeps, "{x: [0, 2]}", "friction: 0");
    if (!repeats) text.erase(text.find("periodic"), text.find("gravity") - text.find("periodic"));
    return scene_from_text(text +
                           "  - {name: a, shape: {sphere: {radius: 0.1}}, mass: 1, position: [1.5, 0, 0], velocity: [1, 0, 0]}\n"
                           "  - {name: b, shape: {sphere: {radius: 0.1}}, mass: 1, position: [1.8, 0, 0], velocity: [1, 0, 0]}\n"
                           "  - {name: c, shape: {sphere: {radius: 0.1}}, mass: 2, position: [" +
                           place + ", 0, 0]}\njoints:\n  - {type: fixed, bodies: [a, b], anchor: [1.65, 0, 0]}\n");
  };
  Experiment run(scene("0.5", true)), without(scene("2.5", false));
  run.seconds(0.8), without.seconds(0.8);  // they touch at 0.5 s
  EXPECT_LT(run.velocity(1).x(), 0.51);
  for (const Id id : {0, 1, 2}) EXPECT_NEAR(run.velocity(id).x(), without.velocity(id).x(), 1e-9) << id;
  for (const Id id : {0, 1}) EXPECT_NEAR(run.position(id).x(), without.position(id).x(), 1e-9) << id;
}

INSTANTIATE_TEST_SUITE_P(Solvers, PeriodicOf,
                         testing::Combine(testing::Values("accelerated_jacobi", "gauss_seidel"), testing::Values(1, 4)));

// The same motion wherever the borders are, but for what rounding grows to.
TEST(Periodic, NoMotionDependsOnTheBorders) {
  for (const char* solver : {"accelerated_jacobi", "gauss_seidel"}) {
    Experiment one(scene_from_text(pile(solver, "{x: [0, 1.2], y: [0, 1.2]}")));
    Experiment other(scene_from_text(pile(solver, "{x: [-0.43, 0.77], y: [7.31, 8.51]}")));
    one.steps(steps_alike), other.steps(steps_alike);
    EXPECT_GT(contact_points(one), 60);
    for (Id id = 1; id <= 64; ++id) EXPECT_LT((one.position(id) - other.position(id)).norm(), 1e-9) << id;
  }
}

// Two cells side by side, each with the same bodies, are one cell twice.
TEST(Periodic, ACellIsTheSameAsTwo) {
  Experiment one(scene_from_text(pile("accelerated_jacobi", "{x: [0, 1.2], y: [0, 1.2]}")));
  Experiment two(scene_from_text(pile("accelerated_jacobi", "{x: [0, 2.4], y: [0, 1.2]}", 2)));
  one.steps(steps_alike), two.steps(steps_alike);
  EXPECT_EQ(contact_points(two), 2 * contact_points(one));
  for (Id id = 1; id <= 64; ++id)
    for (const int copy : {0, 1})
      EXPECT_LT((two.position(2 * id - 1 + copy) - one.position(id) - Vec3(1.2 * copy, 0, 0)).norm(), 1e-9) << id;
}

TEST(Periodic, APlanarSceneRepeatsItselfAlongX) {
  const auto disc = [](double x, double v) {
    return entry("disc: {radius: 0.1}", "mass: 1", "position: " + list({x, 0, 0.1}) + ", velocity: " + list({v, 0, 0}));
  };
  Experiment run(scene_from_text("planar: true\n" +
                                 head("accelerated_jacobi", 1, "{x: [0, 2]}", "friction: 0, restitution: 1", "[0, 0, -9.81]") +
                                 "  - {shape: {plane: {normal: [0, 0, 1]}}}\n" + disc(1.8, 1) + disc(0.1, 0)));
  run.seconds(0.32);
  EXPECT_NEAR(run.velocity(1).x(), 0, 1e-9);
  EXPECT_NEAR(run.velocity(2).x(), 1, 1e-9);
}

// A body that may touch another in two images at once stops the run.
TEST(Periodic, WhatReachesOverHalfOfThePeriodStopsTheRun) {
  Experiment run(scene_from_text(head("accelerated_jacobi", 1, "{x: [0, 2]}", "friction: 0") +
                                 "  - {name: shot, shape: {sphere: {radius: 0.1}}, mass: 1, velocity: [40, 0, 0]}\n"));
  try {
    run.step();
    ADD_FAILURE() << "it goes on";
  } catch (const RunError& error) {
    EXPECT_NE(std::string(error.what()).find("shot: with what it may travel in a step"), std::string::npos) << error.what();
  }
}

TEST(RanksPeriodic, StepsHaveTheSameBits) {
  for (const char* solver : {"accelerated_jacobi", "gauss_seidel"}) {
    const std::string text = pile(solver, "{x: [0, 1.2], y: [0, 1.2]}");
    Experiment alone(scene_from_text(text)), here(scene_from_text(text), MPI_COMM_WORLD);
    alone.steps(40), here.steps(40);
    EXPECT_GT(contact_points(alone), 60);
    for (std::size_t i = 0; i < here.world().homes; ++i) {
      const Id id = here.world().id[i];
      EXPECT_EQ(here.world().position[i], alone.position(id)) << id;
      EXPECT_EQ(here.world().velocity[i], alone.velocity(id)) << id;
    }
  }
}

}  // namespace unibody::small_worlds::periodic_test
