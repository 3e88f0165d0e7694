// Friction that differs along an axis of a body and across it: closed forms, with both solvers, at 1 and 4 substeps.
#include <gtest/gtest.h>

#include <cmath>

#include "report/state_hash.hpp"
#include "small_worlds.hpp"

namespace unibody::small_worlds::anisotropic_friction_test {

namespace {

constexpr double g = 9.81, mu = 0.4, across = 0.25;

std::string head(const std::string& solver, int substeps, const std::string& more = "") {
  return "time: {substeps: " + std::to_string(substeps) + "}\nsolver: {tolerance: 1.0e-10, iterations: 2000, name: " + solver +
         "}\nmaterials: {m: {friction: 0.4" + more + "}}\nbodies:\n";
}
std::string text_of(const Vec3& v) {
  return "[" + std::to_string(v.x()) + ", " + std::to_string(v.y()) + ", " + std::to_string(v.z()) + "]";
}
const std::string grooves = ", anisotropic_friction: {axis: [1, 0, 0], across: 0.25}";
std::string floor_with(const std::string& keys) {
  return "  - {shape: {box: {size: [20, 20, 1]}}, motion: fixed, position: [0, 0, -0.5]" + keys + "}\n";
}
std::string slab(const Vec3& velocity, const std::string& keys = "") {
  return "  - {shape: {box: {size: [0.2, 0.2, 0.02]}}, mass: 2, position: [0, 0, 0.01], velocity: " + text_of(velocity) + keys +
         "}\n";
}

// What friction does to the velocity of a slab that slides on level ground, over g (Moreau's law of largest dissipation): of all
// decelerations in the ellipse with the half axes mu_x and mu_y it is the one that takes most energy, as the slab ends the step.
Vec3 deceleration(const Vec3& sliding, double mu_x, double mu_y) {
  const double x = mu_x * sliding.x(), y = mu_y * sliding.y(), size = std::hypot(x, y);
  return {mu_x * x / size, mu_y * y / size, 0};
}

void expect_sliding(Experiment& run, Id slab, double mu_x, double mu_y, int steps) {
  for (int k = 0; k < steps; ++k) {
    const Vec3 before = run.velocity(slab);
    run.step();
    const Vec3 after = run.velocity(slab);
    EXPECT_LT((before - after - run.h() * g * deceleration(after, mu_x, mu_y)).norm(), 1e-6) << k;
  }
}

}  // namespace

class AnisotropicFriction : public testing::TestWithParam<std::tuple<const char*, int>> {};

// At any angle, of a slab on grooves, of one with grooves of its own, turned about the normal, and of grooves on both sides.
TEST_P(AnisotropicFriction, SlidesByTheLawOfLargestDissipation) {
  const auto [solver, substeps] = GetParam();
  for (const double degrees : {0.0, 20.0, 45.0, 70.0, 90.0}) {
    const Vec3 velocity = 2 * Vec3(std::cos(degrees * M_PI / 180), std::sin(degrees * M_PI / 180), 0);
    Experiment below(scene_from_text(head(solver, substeps) + floor_with(grooves) + slab(velocity)));
    expect_sliding(below, 1, mu, across * mu, 12);
    Experiment turned(scene_from_text(head(solver, substeps) + floor_with("") +
                                      slab(velocity, ", orientation: {axis: [0, 0, 1], angle: 90}" + grooves)));
    expect_sliding(turned, 1, across * mu, mu, 12);
    Experiment both(scene_from_text(head(solver, substeps) + floor_with(grooves) +
                                    slab(velocity, ", anisotropic_friction: {axis: [0, 1, 0], across: 0.5}")));
    expect_sliding(both, 1, 0.5 * mu, across * mu, 12);
  }
}

// Along the path the two velocities follow u_x = c u_y^((mu_x / mu_y)^2); what a step makes of it is of first order.
TEST_P(AnisotropicFriction, FollowsItsPathToFirstOrder) {
  const auto [solver, substeps] = GetParam();
  const auto error = [&, solver = solver](int more) {
    Experiment run(scene_from_text(head(solver, substeps * more) + floor_with(grooves) + slab({3, 1, 0})));
    run.seconds(0.64);
    const Vec3 u = run.velocity(1);
    return u.x() / (3 * std::pow(u.y(), 1 / (across * across))) - 1;
  };
  const double coarse = error(1), fine = error(4);
  EXPECT_LT(std::abs(coarse), 0.5);
  EXPECT_NEAR(coarse / fine, 4, 1);
}

// On a slope that falls at an angle to the grooves, a slab stays where (x / mu_x)^2 + (y / mu_y)^2 <= 1, with x and y the slope's
// tangent along the two directions. Beyond it slides, along a straight line that is not the line of fall.
TEST_P(AnisotropicFriction, OnASlope) {
  const auto [solver, substeps] = GetParam();
  for (const double degrees : {0.0, 30.0, 60.0, 90.0}) {
    const Vec3 fall(std::cos(degrees * M_PI / 180), std::sin(degrees * M_PI / 180), 0);
    const double steepest = 1 / std::hypot(fall.x() / mu, fall.y() / (across * mu));
    const auto scene = [&, solver = solver, substeps = substeps](double slope) {
      const Vec3 gravity = g / std::hypot(1, slope) * (slope * fall - Vec3::UnitZ());
      return scene_from_text("gravity: " + text_of(gravity) + "\n" + head(solver, substeps) + floor_with(grooves) +
                             slab(Vec3::Zero()));
    };
    Experiment stays(scene(0.97 * steepest)), slides(scene(1.5 * steepest));
    stays.seconds(2), slides.seconds(0.48);
    EXPECT_LT((stays.position(1) - Vec3(0, 0, 0.01)).norm(), 1e-4) << degrees;
    const Vec3 u = slides.velocity(1), pull = slides.scene->gravity;
    const Vec3 right = 0.48 * (pull + pull.z() * deceleration(u, mu, across * mu));
    EXPECT_GT(u.norm(), 0.1) << degrees;
    EXPECT_LT((u - Vec3(right.x(), right.y(), 0)).norm(), 1e-5) << degrees;
  }
}

// The ends of the grooves: an axis along the normal leaves the coefficient across it, the same in all directions.
TEST_P(AnisotropicFriction, AnAxisAlongTheNormal) {
  const auto [solver, substeps] = GetParam();
  Experiment run(scene_from_text(head(solver, substeps) + floor_with(", anisotropic_friction: {axis: [0, 0, 1], across: 0.25}") +
                                 slab({1, 1, 0})));
  expect_sliding(run, 1, across * mu, across * mu, 12);
}

// More friction across the axis than along it.
TEST_P(AnisotropicFriction, ARatioAboveOne) {
  const auto [solver, substeps] = GetParam();
  Experiment run(scene_from_text(head(solver, substeps) + floor_with(", anisotropic_friction: {axis: [1, 0, 0], across: 2}") +
                                 slab({1, 0.5, 0})));
  expect_sliding(run, 1, mu, 2 * mu, 6);
}

// A ball that bounces obliquely slides all the while: the impulse across the normal is the one in the ellipse that is nearest to
// what would stop the sliding, whose mobility is 7/2 over the mass along any direction.
TEST_P(AnisotropicFriction, AnObliqueBounce) {
  const auto [solver, substeps] = GetParam();
  Experiment run(scene_from_text("gravity: [0, 0, 0]\n" + head(solver, substeps, ", restitution: 0.5") + floor_with(grooves) +
                                 "  - {shape: {sphere: {radius: 0.1}}, mass: 2, position: [0, 0, 0.3], velocity: [2, 1, -2]}\n"));
  run.seconds(0.32);
  const double limit = mu * 2 * 3, half_x = limit, half_y = across * limit;
  const Vec3 stops = 2 * 2.0 / 7 * Vec3(2, 1, 0);
  double best = 0, least = 1e9;
  for (int round = 0, n = 1000; round < 6; ++round) {  // over the angle, ever closer
    const double reach = round == 0 ? M_PI : 4 * M_PI / std::pow(250.0, round), centre = best;
    for (int k = -n; k <= n; ++k) {
      const double angle = centre + reach * k / n;
      const double away = (Vec3(half_x * std::cos(angle), half_y * std::sin(angle), 0) - stops).norm();
      if (away < least) least = away, best = angle;
    }
  }
  const Vec3 impulse(half_x * std::cos(best), half_y * std::sin(best), 0);
  ASSERT_GT(std::hypot(stops.x() / half_x, stops.y() / half_y), 1) << "it must slide";
  const Vec3 right = Vec3(2, 1, 1) - impulse / 2;
  EXPECT_LT((run.velocity(1) - right).norm(), 1e-6);
  const Vec3 spin = 5.0 / (2 * 2 * 0.01) * Vec3(0, 0, -0.1).cross(-impulse);
  EXPECT_LT((run.state(1).angular_velocity - spin).norm(), 1e-5);
}

// A cloth on grooves, and a grooved slab on a cloth that is held.
TEST_P(AnisotropicFriction, Cloths) {
  const auto [solver, substeps] = GetParam();
  for (const bool along : {true, false}) {
    const Vec3 velocity = along ? Vec3(1, 0, 0) : Vec3(0, 1, 0);
    const double slowed = (along ? 1 : across) * mu * g * 0.16;
    Experiment on_grooves(scene_from_text(head(solver, substeps) + floor_with(grooves) +
                                          "cloths:\n  - {grid: {size: [0.5, 0.5], nodes: [6, 6]}, mass: 0.2, thickness: 0.02, "
                                          "links: {diagonals: both}, position: [0, 0, 0.01], velocity: " +
                                          text_of(velocity) + "}\n"));
    on_grooves.seconds(0.16);
    double mean = 0;
    for (Id id = 1; id <= 36; ++id) mean += on_grooves.velocity(id).dot(velocity) / 36;
    EXPECT_NEAR(mean, 1 - slowed, 1e-4);

    Experiment on_cloth(scene_from_text(
        head(solver, substeps) + "  - {shape: {box: {size: [0.3, 0.3, 0.1]}}, mass: 2, position: [0, 0, 0.06], velocity: " +
        text_of(velocity) + grooves + "}\ncloths:\n" +
        "  - {grid: {size: [4, 4], nodes: [21, 21]}, mass: 1, thickness: 0.02, links: {}, "
        "pins: [{within: {min: [-9, -9, -9], max: [9, 9, 9]}}]}\n"));
    on_cloth.seconds(0.16);
    EXPECT_NEAR(on_cloth.velocity(0).dot(velocity), 1 - slowed, mu * g * on_cloth.h());  // it comes to lie in the first step
  }
}

INSTANTIATE_TEST_SUITE_P(Solvers, AnisotropicFriction,
                         testing::Combine(testing::Values("accelerated_jacobi", "gauss_seidel"), testing::Values(1, 4)),
                         [](const auto& of) {
                           return std::string(std::get<0>(of.param)) + "_" + std::to_string(std::get<1>(of.param));
                         });

// A heap of grooved bodies of several shapes that falls on a grooved floor, with bounces and a cloth under it.
TEST(RanksAnisotropicFriction, HasTheSameBitsOnAnyNumberOfRanks) {
  for (const std::string solver : {"accelerated_jacobi", "gauss_seidel"}) {
    const std::string scene =
        "time: {substeps: 2}\nsolver: {name: " + solver + "}\nmaterials: {m: {friction: 0.5, restitution: 0.3}}\nbodies:\n" +
        floor_with(grooves) +
        "  - {pile: {count: 60, columns: [4, 4], mix: [{shape: {box: {size: [0.1, 0.1, 0.1]}}}, {shape: {sphere: {radius: "
        "0.05}}}, "
        "{shape: {hull: {points: [[0, 0, 0], [0.1, 0, 0], [0, 0.1, 0], [0, 0, 0.1]]}}}]}, density: 1000, position: [0, 0, 0.3], "
        "velocity: [1, 0.5, -2]" +
        grooves +
        "}\n  - {pile: {count: 20, columns: [3, 3], mix: [{shape: {sphere: {radius: 0.05}}}]}, density: 1000, position: [0, 0, "
        "2]}\n"
        "cloths:\n  - {grid: {size: [0.6, 0.6], nodes: [8, 8]}, mass: 0.3, thickness: 0.02, links: {}, position: [0, 0, 0.1]}\n";
    Experiment all(scene_from_text(scene), MPI_COMM_WORLD), alone(scene_from_text(scene));
    all.steps(40), alone.steps(40);
    EXPECT_EQ(state_hash(MPI_COMM_WORLD, all.world()), state_hash(MPI_COMM_SELF, alone.world())) << solver;
  }
}

}  // namespace unibody::small_worlds::anisotropic_friction_test
