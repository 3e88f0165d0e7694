// Contacts that give way: how long bodies touch, how far they overlap, how they rebound and rest, in closed form.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

#include "constraints/compliance.hpp"
#include "report/elastic_energy.hpp"
#include "report/measure.hpp"
#include "small_worlds.hpp"

namespace unibody::small_worlds::compliant_contact_test {

namespace {

constexpr double g = 9.81;

std::string number(double x) {
  char text[32];
  std::snprintf(text, sizeof text, "%.17g", x);
  return std::string(text).find_first_of(".e") == std::string::npos ? std::string(text) + ".0" : text;
}

std::string head(const std::string& solver, double frame, const std::string& material, double gravity = 0) {
  return "time: {frame: " + number(frame) + "}\nsolver: {name: " + solver + "}\ngravity: [0, 0, " + number(-gravity) +
         "]\nmaterials: {m: {" + material + "}}\nbodies:\n";
}

const char* const floor_entry = "  - {shape: {plane: {normal: [0, 0, 1]}}}\n";

std::string ball(double mass, double radius, double z, double speed) {
  return "  - {shape: {sphere: {radius: " + number(radius) + "}}, mass: " + number(mass) + ", position: [0, 0, " + number(z) +
         "], velocity: [0, 0, " + number(speed) + "]}\n";
}

struct Impact {
  double time = 0, overlap = 0, force = 0, speed = 0;  // s, m, N (the most), m/s (afterwards)
};

// Of a ball of 1 kg and a radius of 0.1 m that meets the floor at 1 m/s.
Impact impact_of(const std::string& solver, double h, const std::string& material) {
  Experiment run(scene_from_text(head(solver, h, material) + floor_entry + ball(1, 0.1, 0.1 + 0.3 * h, -1)));
  Impact impact;
  for (int k = 0; k < 100000 && (impact.time == 0 || run.position(1).z() < 0.1); ++k) {
    run.step();
    EXPECT_TRUE(run.last.converged) << "step " << k;
    const double force = run.normal_force(0, 1);
    impact.time += force > 0 ? h : 0, impact.force = std::max(impact.force, force);
    impact.overlap = std::max(impact.overlap, 0.1 - run.position(1).z());
  }
  impact.speed = run.velocity(1).z();
  return impact;
}

// The same by Runge and Kutta's method, for any force(overlap, speed of approach) that never pulls.
Impact converged_impact(const std::function<double(double, double)>& force) {
  const double h = 1e-7;
  const auto push = [&](double x, double v) { return x > 0 ? std::max(0.0, force(x, v)) : 0; };
  Impact impact;
  double x = 0, v = 1;
  while (impact.time < h || push(x, v) > 0) {
    const double a1 = -push(x, v), v1 = v + h / 2 * a1, a2 = -push(x + h / 2 * v, v1), v2 = v + h / 2 * a2;
    const double a3 = -push(x + h / 2 * v1, v2), v3 = v + h * a3, a4 = -push(x + h * v2, v3);
    x += h / 6 * (v + 2 * v1 + 2 * v2 + v3), v += h / 6 * (a1 + 2 * a2 + 2 * a3 + a4);
    impact.time += h, impact.overlap = std::max(impact.overlap, x), impact.force = std::max(impact.force, push(x, v));
  }
  impact.speed = -v;
  return impact;
}

}  // namespace

class ComplianceOf : public testing::TestWithParam<const char*> {};

TEST_P(ComplianceOf, ABallReboundsFromASpring) {
  const double k = 1e5, omega = std::sqrt(k);
  const Impact impact = impact_of(GetParam(), 1e-4, "friction: 0, stiffness: 1.0e+5");
  EXPECT_NEAR(impact.time, M_PI / omega, 1.5e-4);
  EXPECT_NEAR(impact.overlap, 1 / omega, 2e-3 / omega);
  EXPECT_NEAR(impact.force, omega, 2e-3 * omega);
  EXPECT_NEAR(impact.speed, 1, 2e-3);
}

// The ball leaves when nothing pushes it any more, before the spring has its length again (Schwager & Poeschel, Granular Matter
// 9, 2007, 465).
TEST_P(ComplianceOf, ADamperTakesSpeed) {
  const double k = 1e5, omega = std::sqrt(k);
  for (const double ratio : {0.1, 0.3, 0.6}) {
    const double swing = std::sqrt(1 - ratio * ratio),
                 end = (M_PI - std::atan2(2 * ratio * swing, 1 - 2 * ratio * ratio)) / swing;
    for (const std::string& damping : {"damping_ratio: " + number(ratio), "damping: " + number(2 * ratio * omega)}) {
      const Impact impact = impact_of(GetParam(), 1e-4, "friction: 0, stiffness: 1.0e+5, " + damping);
      EXPECT_NEAR(impact.speed, std::exp(-ratio * end), 0.01) << damping;
      EXPECT_NEAR(impact.time, end / omega, 2.5e-4) << damping;
    }
  }
}

// delta = (5 m v^2 / (4 kappa))^(2/5), for 2.9432 delta / v, with kappa = 4/3 E* sqrt(R).
TEST_P(ComplianceOf, ABallReboundsByHertzLaw) {
  const double kappa = 4.0 / 3 * 1e7 * std::sqrt(0.1), overlap = std::pow(5 / (4 * kappa), 0.4);
  const Impact impact = impact_of(GetParam(), 5e-5, "friction: 0, elastic_modulus: 1.0e+7");
  EXPECT_NEAR(impact.overlap, overlap, 2e-3 * overlap);
  EXPECT_NEAR(impact.force, kappa * std::pow(overlap, 1.5), 3e-3 * kappa * std::pow(overlap, 1.5));
  EXPECT_NEAR(impact.time, 2.9432 * overlap, 1e-4);
  EXPECT_NEAR(impact.speed, 1, 2e-3);

  const double ratio = 0.25;
  const Impact damped = impact_of(GetParam(), 5e-5, "friction: 0, elastic_modulus: 1.0e+7, damping_ratio: 0.25");
  const Impact reference = converged_impact(
      [&](double x, double v) { return kappa * std::pow(x, 1.5) + 2 * ratio * std::sqrt(1.5 * kappa * std::sqrt(x)) * v; });
  EXPECT_NEAR(damped.speed, reference.speed, 0.01);
  EXPECT_NEAR(damped.overlap, reference.overlap, 0.01 * reference.overlap);
}

// By their reduced mass, with the momentum that they had.
TEST_P(ComplianceOf, TwoBallsMeet) {
  const double h = 1e-4, k = 1e5, mass = 1 * 3.0 / 4, omega = std::sqrt(k / mass);
  Experiment run(scene_from_text(head(GetParam(), h, "friction: 0, stiffness: 1.0e+5") + ball(1, 0.1, 0.2 + 0.4 * h, -1) +
                                 ball(3, 0.1, 0, 0)));
  double time = 0;
  for (int i = 0; i < 200; ++i) run.step(), time += run.normal_force(0, 1) > 0 ? h : 0;
  EXPECT_NEAR(time, M_PI / omega, 1.5 * h);
  EXPECT_NEAR(run.velocity(0).z(), 0.5, 2e-3);  // (m1 - m2) / (m1 + m2) of -1
  EXPECT_NEAR(run.velocity(1).z(), -0.5, 2e-3);
  EXPECT_NEAR(run.momentum().z(), -1, 1e-12);
}

// Each contact bears all that lies on it.
TEST_P(ComplianceOf, AStackRestsOnItsSprings) {
  const double k = 1e4;
  Experiment run(scene_from_text(head(GetParam(), 1e-3, "friction: 0.3, stiffness: 1.0e+4, damping_ratio: 0.5", g) + floor_entry +
                                 ball(1, 0.1, 0.1, 0) + ball(1, 0.1, 0.3, 0) + ball(1, 0.1, 0.5, 0)));
  run.seconds(3);
  for (const Id above : {1, 2, 3}) {
    const double borne = (4 - static_cast<double>(above)) * g;
    EXPECT_NEAR(run.gap(above - 1, above), -borne / k, 1e-4 * borne / k);
    EXPECT_NEAR(run.normal_force(above - 1, above), borne, 1e-4 * borne);
  }
}

// Whatever else the solver is told to do.
TEST_P(ComplianceOf, AStackRestsOnItsSpringsWithAllSettings) {
  for (const char* setting : {"friction: cone", "friction: saxce", "friction: box", "friction: none", "friction: postprocess",
                              "gap: reevaluated", "level: velocity", "stages: position", "stages: two", "stages: together"}) {
    Experiment run(scene_from_text(
        head(std::string(GetParam()) + ", " + setting, 1e-3, "friction: 0.3, stiffness: 1.0e+4, damping_ratio: 0.5", g) +
        floor_entry + ball(1, 0.1, 0.1, 0) + ball(2, 0.1, 0.3, 0)));
    run.seconds(2);
    EXPECT_NEAR(run.gap(1, 2), -2 * g / 1e4, 2e-4 * g / 1e4) << setting;
    EXPECT_NEAR(run.gap(0, 1), -3 * g / 1e4, 3e-4 * g / 1e4) << setting;
  }
}

// Four corners are four springs.
TEST_P(ComplianceOf, ABoxRestsOnItsCornersAndSlides) {
  const double k = 1e4, sunk = g / (4 * k);
  Experiment run(scene_from_text(head(GetParam(), 1e-3, "friction: 0.3, stiffness: 1.0e+4, damping_ratio: 0.5", g) + floor_entry +
                                 "  - {shape: {box: {size: [0.4, 0.4, 0.1]}}, mass: 1, position: [0, 0, " + number(0.05 - sunk) +
                                 "], velocity: [1, 0, 0]}\n"));
  run.seconds(0.2);
  EXPECT_NEAR(run.velocity(1).x(), 1 - 0.3 * g * 0.2, 5e-3);
  run.seconds(1.8);
  EXPECT_NEAR(run.position(1).z(), 0.05 - sunk, 1e-3 * sunk);
  EXPECT_NEAR(run.velocity(1).norm(), 0, 1e-5);
}

// A step that is far too long for the contact: the ball comes to rest where the spring holds it, and gains nothing on the way.
TEST_P(ComplianceOf, AnUnresolvedContactIsStable) {
  const double k = 1e6;
  Experiment run(
      scene_from_text(head(GetParam(), 0.016, "friction: 0.3, stiffness: 1.0e+6", g) + floor_entry + ball(1, 0.1, 0.4, 0)));
  double highest = 0;
  for (int i = 0; i < 200; ++i) {
    run.step();
    if (run.velocity(1).z() > 0) highest = std::max(highest, run.position(1).z());
  }
  EXPECT_LT(highest, 0.4);
  EXPECT_NEAR(run.gap(0, 1), -g / k, 0.02 * g / k);
  EXPECT_NEAR(run.normal_force(0, 1), g, 1e-3 * g);
}

// Kinetic energy and that of the springs stay what they were, of balls that have many contacts at once.
TEST_P(ComplianceOf, EnergyIsKeptInACrowd) {
  std::string text = head(GetParam(), 1e-4, "friction: 0, elastic_modulus: 1.0e+6");
  for (const char* wall : {"[1, 0, 0]", "[-1, 0, 0]", "[0, 1, 0]", "[0, -1, 0]", "[0, 0, 1]", "[0, 0, -1]"}) {
    std::string at = wall;
    at = at.find('-') == std::string::npos ? "[0, 0, 0]" : "[0.605, 0.605, 0.605]";
    text += "  - {shape: {plane: {normal: " + std::string(wall) + "}}, position: " + at + "}\n";
  }
  for (int k = 0; k < 27; ++k) {
    const double x = 0.1 + 0.2015 * (k % 3), y = 0.1 + 0.2015 * (k / 3 % 3), z = 0.1 + 0.2015 * (k / 9);
    const auto speed = [&](int n) { return number(0.5 * std::sin(12.9898 * k + 78.233 * n)); };
    text += "  - {shape: {sphere: {radius: 0.1}}, mass: 1, position: [" + number(x) + ", " + number(y) + ", " + number(z) +
            "], velocity: [" + speed(1) + ", " + speed(2) + ", " + speed(3) + "]}\n";
  }
  Experiment run(scene_from_text(text));
  const auto elastic = [&] {  // 8/15 E* sqrt(R) delta^(5/2)
    run.simulation->detect();
    double sum = 0;
    for (const Manifold& m : run.simulation->contacts.manifolds)
      for (std::uint32_t p = m.first; p < m.first + m.count; ++p)
        sum += 8.0 / 15 * 1e6 * std::sqrt(m.id_a < 6 ? 0.1 : 0.05) *
               std::pow(std::max(0.0, -run.simulation->contacts.points[p].gap), 2.5);
    return sum;
  };
  const double before = run.kinetic_energy() + elastic();
  double most_elastic = 0;
  for (int i = 0; i < 40; ++i) {
    run.steps(50);
    const double now = elastic();
    most_elastic = std::max(most_elastic, now);
    EXPECT_NEAR(contact_energy(MPI_COMM_SELF, run.world(), run.simulation->contacts, run.scene->pairs), now, 1e-9 * before);
    EXPECT_NEAR(run.kinetic_energy() + now, before, 0.01 * before);
  }
  EXPECT_GT(most_elastic, 0.2 * before);
}

INSTANTIATE_TEST_SUITE_P(Solvers, ComplianceOf, testing::Values("accelerated_jacobi", "jacobi", "gauss_seidel"));

// What is meant to overlap does not penetrate; what is rigid beside it does.
TEST(Compliance, AnOverlapThatIsMeantIsNoPenetration) {
  const std::string text = "materials: {soft: {friction: 0, stiffness: 1.0e+3}, hard: {friction: 0}}\nbodies:\n";
  const auto two = [&](const std::string& material, double x, double apart) {
    const auto one = [&](double z) {
      return "  - {shape: {sphere: {radius: 0.1}}, mass: 1, material: " + material + ", position: [" + number(x) + ", 0, " +
             number(z) + "]}\n";
    };
    return one(0) + one(0.2 - apart);
  };
  Experiment run(scene_from_text(text + two("soft", 0, 0.02) + two("hard", 1, 0.003)));
  run.simulation->detect();
  const Measures m = measure(MPI_COMM_SELF, run.world(), run.simulation->contacts, Vec3::Zero(), 0, &run.scene->pairs);
  EXPECT_NEAR(m.penetration_max, 0.003, 1e-12);
  EXPECT_EQ(m.pairs, 2);
  EXPECT_NEAR(contact_energy(MPI_COMM_SELF, run.world(), run.simulation->contacts, run.scene->pairs), 0.5 * 1e3 * 0.02 * 0.02,
              1e-12);
}

// A pair has the geometric mean of its materials' stiffnesses: with a rigid material it is rigid.
TEST(Compliance, APairWithARigidMaterialIsRigid) {
  Experiment run(
      scene_from_text("gravity: [0, 0, -9.81]\nmaterials: {soft: {friction: 0.3, stiffness: 1.0e+3, damping_ratio: 1}, "
                      "hard: {friction: 0.3}}\nbodies:\n"
                      "  - {shape: {plane: {normal: [0, 0, 1]}}, material: hard}\n"
                      "  - {shape: {sphere: {radius: 0.1}}, mass: 1, position: [0, 0, 0.1], material: soft}\n"
                      "  - {shape: {sphere: {radius: 0.1}}, mass: 1, position: [0, 0, 0.3], material: soft}\n"));
  run.seconds(4);
  EXPECT_NEAR(run.gap(0, 1), 0, 2e-5);
  EXPECT_NEAR(run.gap(1, 2), -g / 1e3, 1e-3 * g / 1e3);
}

TEST(Compliance, HertzLawNeedsARoundBody) {
  EXPECT_FALSE((ContactLaw{.modulus = 1e6, .radius = 0}.complies()));
  EXPECT_TRUE((ContactLaw{.modulus = 1e6, .radius = 0.1}.complies()));
  EXPECT_TRUE((ContactLaw{.stiffness = 1e6}.complies()));
}

TEST(Compliance, TheContactTimeOfTheLaws) {
  EXPECT_NEAR(contact_time({.stiffness = 1e5}, 1), M_PI / std::sqrt(1e5), 1e-12);
  // Of the speed at which a thousandth of R is the overlap, by the formulas of the impact above.
  const double kappa = 4.0 / 3 * 1e7 * std::sqrt(0.1), overlap = 1e-4, speed = std::sqrt(0.8 * kappa * std::pow(overlap, 2.5));
  EXPECT_NEAR(contact_time({.modulus = 1e7, .radius = 0.1}, 1), 2.9432 * overlap / speed, 1e-9);
}

}  // namespace unibody::small_worlds::compliant_contact_test
