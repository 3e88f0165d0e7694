// Surfaces that move along themselves, as those of belts: closed forms, with both solvers, at 1 and 4 substeps.
#include <gtest/gtest.h>

#include <cmath>

#include "small_worlds.hpp"

namespace unibody::small_worlds::surface_motion_test {

namespace {

constexpr double g = 9.81, mu = 0.4;

std::string head(const std::string& solver, int substeps, const std::string& material = "friction: 0.4") {
  return "time: {substeps: " + std::to_string(substeps) + "}\nsolver: {tolerance: 1.0e-9, name: " + solver +
         "}\nmaterials: {m: {" + material + "}}\nbodies:\n";
}
std::string at_defaults(const std::string& solver, int substeps, const std::string& material) {
  std::string text = head(solver, substeps, material);
  return text.replace(text.find("tolerance: 1.0e-9, "), 19, "");
}
std::string belt(const std::string& velocity = "[1, 0, 0]") {
  return "  - {shape: {box: {size: [20, 2, 1]}}, motion: fixed, position: [8, 0, -0.5], surface_velocity: " + velocity + "}\n";
}
const std::string box = "  - {shape: {box: {size: [0.2, 0.2, 0.2]}}, mass: 2, position: [0, 0, 0.1]}\n";

// The body starts at rest and slides, at mu g, until it is as fast as the surface; then it goes with it.
void expect_taken_along(Experiment& run, Id body, double speed, double share = 1e-5) {
  const double start = run.position(body).x();
  const int n = static_cast<int>(std::lround(1 / run.h()));
  for (int k = 1; k <= n; ++k) {
    run.step();
    EXPECT_NEAR(run.velocity(body).x(), std::min(speed, mu * g * k * run.h()), share * speed) << "step " << k;
  }
  EXPECT_NEAR(run.position(body).x() - start, speed * n * run.h() - speed * speed / (2 * mu * g), speed * run.h());
}

}  // namespace

class SurfaceMotionOf : public testing::TestWithParam<std::tuple<const char*, int>> {};

TEST_P(SurfaceMotionOf, ABeltTakesABoxAlong) {
  const auto [solver, substeps] = GetParam();
  for (const FrictionModel model : {FrictionModel::disc, FrictionModel::saxce, FrictionModel::box}) {
    Scene scene = scene_from_text(head(solver, substeps) + belt() + box);
    scene.solver.friction = model;
    Experiment run(std::move(scene));
    expect_taken_along(run, 1, 1);
    EXPECT_NEAR(run.position(1).z(), 0.1, 1e-4);
  }
}

TEST_P(SurfaceMotionOf, ABeltThatStops) {
  const auto [solver, substeps] = GetParam();
  Experiment run(scene_from_text(head(solver, substeps) + belt("[{table: [[0, 1], [1, 0]], between: steps}, 0, 0]") + box));
  run.seconds(0.96);
  EXPECT_NEAR(run.velocity(1).x(), 1, 1e-5);
  run.seconds(1);
  EXPECT_NEAR(run.velocity(1).norm(), 0, 1e-5);
}

// What sticks on a slope goes up with the belt; with too little friction it slides down, whatever the belt does.
TEST_P(SurfaceMotionOf, ABeltUphill) {
  const auto [solver, substeps] = GetParam();
  const double slope = 20 * M_PI / 180;
  const Vec3 up{std::cos(slope), 0, std::sin(slope)}, n{-std::sin(slope), 0, std::cos(slope)};
  const auto scene = [&](const std::string& friction, double speed) {
    const auto list = [](const Vec3& v) {
      return "[" + std::to_string(v.x()) + ", " + std::to_string(v.y()) + ", " + std::to_string(v.z()) + "]";
    };
    const std::string turned = ", orientation: {axis: [0, 1, 0], angle: -20}, ";
    return scene_from_text(head(solver, substeps, "friction: " + friction) +
                           "  - {shape: {box: {size: [20, 2, 1]}}, motion: fixed" + turned + "position: " + list(-0.5 * n) +
                           ", surface_velocity: [1, 0, 0]}\n" + "  - {shape: {box: {size: [0.2, 0.2, 0.2]}}, mass: 2" + turned +
                           "position: " + list(0.1 * n) + ", velocity: " + list(speed * up) + "}\n");
  };
  Experiment sticks(scene("0.5", 1)), slides(scene("0.2", 0));
  sticks.seconds(2), slides.seconds(0.48);
  EXPECT_LT((sticks.position(1) - 0.1 * n - 2 * up).norm(), 2e-4);
  EXPECT_NEAR(slides.velocity(1).dot(up), -0.48 * g * (std::sin(slope) - 0.2 * std::cos(slope)), 1e-4);
}

// A surface that turns about its normal carries along circles.
TEST_P(SurfaceMotionOf, ATurntableThatStandsStill) {
  const auto [solver, substeps] = GetParam();
  Experiment run(scene_from_text(at_defaults(solver, substeps, "friction: 0.5") +
                                 "  - {shape: {cylinder: {radius: 3, length: 0.1}}, motion: fixed, position: [0, 0, -0.05], "
                                 "surface_angular_velocity: [0, 0, 2]}\n"
                                 "  - {shape: {box: {size: [0.1, 0.1, 0.1]}}, mass: 1, position: [0.5, 0, 0.05], "
                                 "velocity: [0, 1, 0], angular_velocity: [0, 0, 2]}\n"));
  run.seconds(30);
  const Vec3 at = run.position(1);
  EXPECT_NEAR(std::hypot(at.x(), at.y()), 0.5, 1e-4);
  EXPECT_NEAR(std::remainder(std::atan2(at.y(), at.x()) - 60, 2 * M_PI), 0, 0.01);
  EXPECT_NEAR(run.state(1).angular_velocity.z(), 2, 1e-4);
}

// A plank on two rollers, whose surfaces turn while they do not: 4 rad/s at 0.25 m.
TEST_P(SurfaceMotionOf, RollersTakeAPlankAlong) {
  const auto [solver, substeps] = GetParam();
  const auto roller = [](const char* x) {
    return std::string("  - {shape: {cylinder: {radius: 0.25, length: 1}}, motion: fixed, position: [") + x +
           ", 0, -0.25], orientation: {axis: [1, 0, 0], angle: 90}, surface_angular_velocity: [0, 0, -4]}\n";
  };
  Experiment run(scene_from_text(head(solver, substeps) + roller("-1") + roller("1") +
                                 "  - {shape: {box: {size: [6, 0.4, 0.1]}}, mass: 2, position: [-0.5, 0, 0.05]}\n"));
  expect_taken_along(run, 2, 1, 1e-4);
}

// Tracks: the surface of a body that is free. Its ground pushes it forwards.
TEST_P(SurfaceMotionOf, AVehicleWithTracks) {
  const auto [solver, substeps] = GetParam();
  const std::string tracks =
      "  - {shape: {box: {size: [0.6, 0.4, 0.1]}}, mass: 2, surface_velocity: [-1, 0, 0], position: [0, 0, 0.05]}\n";
  Experiment run(scene_from_text(head(solver, substeps) + "  - {shape: {plane: {normal: [0, 0, 1]}}}\n" + tracks));
  expect_taken_along(run, 1, 1);
}

// A ball is set on the belt at rest. Once it no longer slides it has 2/7 of the belt's speed, and rolls, whatever the friction.
TEST_P(SurfaceMotionOf, ABallOnABelt) {
  const auto [solver, substeps] = GetParam();
  Experiment run(scene_from_text(head(solver, substeps) + belt("[1, 0.5, 0]") +
                                 "  - {shape: {sphere: {radius: 0.1}}, mass: 2, position: [0, 0, 0.1]}\n"));
  run.seconds(0.8);
  EXPECT_NEAR(run.velocity(1).x(), 2.0 / 7, 1e-5);
  EXPECT_NEAR(run.velocity(1).y(), 1.0 / 7, 1e-5);
  EXPECT_NEAR(run.state(1).angular_velocity.y(), -5.0 / 7 / 0.1, 1e-4);
  EXPECT_NEAR(run.state(1).angular_velocity.x(), 2.5 / 7 / 0.1, 1e-4);
}

// A ball strikes a belt at 2 m/s and bounces: it slides through the impact where mu (1 + e) v is less than 2/7 of the belt's
// speed, else it sticks before the end.
TEST_P(SurfaceMotionOf, ABallBouncesOffABelt) {
  const auto [solver, substeps] = GetParam();
  for (const auto& [friction, along] : {std::pair{"0.1", 0.3}, {"0.9", 6.0 / 7}}) {
    Experiment run(scene_from_text(
        "gravity: [0, 0, 0]\n" + head(solver, substeps, std::string("restitution: 0.5, friction: ") + friction) +
        belt("[3, 0, 0]") + "  - {shape: {sphere: {radius: 0.1}}, mass: 2, position: [0, 0, 0.2], velocity: [0, 0, -2]}\n"));
    run.seconds(0.16);
    EXPECT_NEAR(run.velocity(1).z(), 1, 1e-6) << friction;
    EXPECT_NEAR(run.velocity(1).x(), along, 1e-5) << friction;
    EXPECT_NEAR(run.state(1).angular_velocity.y(), -2.5 * along / 0.1, 1e-3) << friction;
  }
}

// A cloth lies on a belt, and a vehicle with tracks on a cloth, all of which is held.
TEST_P(SurfaceMotionOf, ClothsBothWays) {
  const auto [solver, substeps] = GetParam();
  Experiment on_belt(scene_from_text(head(solver, substeps) + belt() +
                                     "cloths:\n  - {grid: {size: [0.5, 0.5], nodes: [6, 6]}, mass: 0.2, thickness: 0.02, "
                                     "links: {diagonals: both}, position: [0, 0, 0.01]}\n"));
  const auto mean = [&] {
    double sum = 0;
    for (Id id = 1; id <= 36; ++id) sum += on_belt.velocity(id).x() / 36;
    return sum;
  };
  on_belt.seconds(0.16);
  EXPECT_NEAR(mean(), mu * g * 0.16, 1e-4);
  on_belt.seconds(0.8);
  EXPECT_NEAR(mean(), 1, 1e-4);

  Scene scene = scene_from_text(head(solver, substeps) +
                                "  - {shape: {box: {size: [0.3, 0.3, 0.1]}}, mass: 2, surface_velocity: [-1, 0, 0], "
                                "position: [-1, 0, 0.06]}\n"
                                "cloths:\n  - {grid: {size: [4, 1], nodes: [21, 6]}, mass: 1, thickness: 0.02, links: {}, "
                                "pins: [{within: {min: [-9, -9, -9], max: [9, 9, 9]}}]}\n");
  Experiment on_cloth(std::move(scene));
  on_cloth.seconds(0.16);
  EXPECT_NEAR(on_cloth.velocity(0).x(), mu * g * 0.16, mu * g * on_cloth.h());  // it comes to lie in the first step
  on_cloth.seconds(0.8);
  EXPECT_NEAR(on_cloth.velocity(0).x(), 1, 0.01);
}

// Spinning friction turns a ball with the surface that it lies on, at most by its torque: 5/2 c g / r^2 rad/s^2.
TEST_P(SurfaceMotionOf, SpinningFriction) {
  const auto [solver, substeps] = GetParam();
  Experiment run(scene_from_text(head(solver, substeps, "friction: 0.5, spinning_friction: 0.001") +
                                 "  - {shape: {cylinder: {radius: 3, length: 0.1}}, motion: fixed, position: [0, 0, -0.05], "
                                 "surface_angular_velocity: [0, 0, 2]}\n"
                                 "  - {shape: {sphere: {radius: 0.1}}, mass: 1, position: [0, 0, 0.1]}\n"));
  run.seconds(0.32);
  EXPECT_NEAR(run.state(1).angular_velocity.z(), 2.5 * 0.001 * g / 0.01 * 0.32, 1e-4);
  run.seconds(1);
  EXPECT_NEAR(run.state(1).angular_velocity.z(), 2, 1e-4);
}

INSTANTIATE_TEST_SUITE_P(All, SurfaceMotionOf,
                         testing::Combine(testing::Values("accelerated_jacobi", "gauss_seidel"), testing::Values(1, 4)));

// With `friction: postprocess` the solve has no friction; friction then acts on the velocities that the solve has found, and sees
// the belt as well.
TEST(SurfaceMotion, FrictionAfterTheSolve) {
  Scene scene = scene_from_text(head("accelerated_jacobi", 1) + belt() + box);
  scene.solver.friction = FrictionModel::postprocess;
  Experiment run(std::move(scene));
  run.seconds(1);
  EXPECT_NEAR(run.velocity(1).x(), 1, 1e-3);
}

TEST(SurfaceMotion, OfPlanarScenesAndHullsInTheirOwnAxes) {
  Experiment planar(scene_from_text("planar: true\n" + head("accelerated_jacobi", 1) + belt() +
                                    "  - {shape: {disc: {radius: 0.1}}, mass: 2, position: [0, 0, 0.1]}\n"));
  planar.seconds(1);
  EXPECT_NEAR(planar.velocity(1).x(), 1.0 / 3, 1e-5);  // a disc's moment of inertia is m r^2 / 2

  // A slab, oblique seen from above, whose principal axes are not those of the file.
  Experiment hull(scene_from_text(head("accelerated_jacobi", 1) +
                                  "  - {shape: {hull: {points: [[-6, -1, -0.5], [4, -1, -0.5], [-4, 1, -0.5], [6, 1, -0.5], "
                                  "[-6, -1, 0.5], [4, -1, 0.5], [-4, 1, 0.5], [6, 1, 0.5]]}}, motion: fixed, "
                                  "position: [0, 0, -0.5], surface_velocity: [1, 0, 0]}\n" +
                                  box));
  EXPECT_GT(hull.state(0).orientation.angularDistance(Quat::Identity()), 0.01);
  expect_taken_along(hull, 1, 1);
}

TEST(RanksSurfaceMotion, StepsHaveTheSameBits) {
  const std::string text = head("accelerated_jacobi", 1) + belt("[{sine: {amplitude: 1, frequency: 2}}, 0, 0]") +
                           "  - {shape: {box: {size: [0.2, 0.2, 0.2]}}, mass: 2, lattice: {count: 24, columns: [4, 2], "
                           "spacing: [0.21, 0.21, 0.21], height: 0.12}}\n";
  Experiment alone(scene_from_text(text)), here(scene_from_text(text), MPI_COMM_WORLD);
  alone.steps(40), here.steps(40);
  for (std::size_t i = 0; i < here.world().homes; ++i) {
    const Id id = here.world().id[i];
    EXPECT_EQ(here.world().position[i], alone.position(id)) << id;
    EXPECT_EQ(here.world().velocity[i], alone.velocity(id)) << id;
  }
}

}  // namespace unibody::small_worlds::surface_motion_test
