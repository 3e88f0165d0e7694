// A strip of cloth that is held at one end and bends under its own weight, against the heavy elastica.
#include <gtest/gtest.h>

#include <cmath>
#include <sstream>

#include "solve/reference_bench.hpp"

namespace unibody::small_worlds::elastica_test {

namespace {

constexpr double density = 0.1, g = 9.81;     // kg/m^2, m/s^2
constexpr double rigidity = density * g / 4;  // N m: weight L^3 / B is 4 for L = 1 m, so that the tip sinks by some 0.4 L
constexpr double stiffness = 1.5 * rigidity;  // N m/rad of each inner edge, see below

struct Tip {
  double reach = 0, drop = 0;  // m
};

// B theta'' = -w (L - s) cos theta, theta(0) = 0, theta'(L) = 0, for the angle theta below the horizontal: by shooting for the
// curvature at the clamp, with Runge and Kutta's method.
Tip heavy_elastica(double L) {
  constexpr int n = 1000;
  const double d = L / n;
  using State = Eigen::Vector4d;  // theta, theta', x, z
  const auto rate = [&](double s, const State& y) {
    return State(y[1], -density * g / rigidity * (L - s) * std::cos(y[0]), std::cos(y[0]), std::sin(y[0]));
  };
  const auto shoot = [&](double curvature) {
    State y(0, curvature, 0, 0);
    for (int i = 0; i < n; ++i) {
      const double s = i * d;
      const State a = rate(s, y), b = rate(s + d / 2, y + d / 2 * a), c = rate(s + d / 2, y + d / 2 * b),
                  e = rate(s + d, y + d * c);
      y += d / 6 * (a + 2 * b + 2 * c + e);
    }
    return y;
  };
  double low = 0, high = density * g * L * L / (2 * rigidity);  // the moment of a straight strip is the largest
  for (int k = 0; k < 60; ++k) (shoot(0.5 * (low + high))[1] > 0 ? high : low) = 0.5 * (low + high);
  const State end = shoot(low);
  return {end[2], end[3]};
}

// One row of n square cells, 1 m long, with stiff links; its first cell is held. A moment M across the width a turns the strip by
// M / (k a) at each transverse edge, and at each diagonal by M / (sqrt 2 k a) about an axis at 45 degrees: by half as much along
// the strip, and by a twist that the next diagonal takes back. Together 3/2 M / (k a) for each cell of length a, hence B = 2/3 k.
Scene strip(int n) {
  std::ostringstream text;
  text.precision(17);
  text << "gravity: [0, 0, " << -g << "]\ncloths:\n  - grid: {size: [1, " << 1.0 / n << "], nodes: [" << n + 1 << ", 2]}\n"
       << "    mass_per_area: " << density << "\n    thickness: 0.001\n    links: {diagonals: alternating}\n"
       << "    bending: {model: dihedral, stiffness: " << stiffness << ", damping: 0.1}\n    position: [0.5, 0, 0]\n"
       << "    pins: [{node: [0, 0]}, {node: [0, 1]}, {node: [1, 0]}, {node: [1, 1]}]\n";
  Scene scene = scene_from_text(text.str());
  scene.solver.tolerance = 0;
  return scene;
}

// In units of M / (k a) a free cell turns by 1 at its first edge and by 1/2 in its middle: 5/4 in the mean over its length. So
// does an even strip, of 3/2 a cell, that begins a third of a cell before that edge.
double free_length(int n) { return 1 - 2.0 / (3 * n); }

Vec3 tip_of(const Experiment& run, int n) { return 0.5 * (run.position(n) + run.position(2 * n + 1)); }

// Error of the tip's place over the drop.
double error_of(const Vec3& tip, int n) {
  const Tip exact = heavy_elastica(free_length(n));
  return std::hypot(tip.x() - (1 - free_length(n)) - exact.reach, -tip.z() - exact.drop) / exact.drop;
}

}  // namespace

// The comparison itself: w L^4 / 8 B for small loads, and less for large ones.
TEST(Elastica, SmallDropsAreThoseOfTheBeam) {
  const double L = 0.1, linear = density * g * std::pow(L, 4) / (8 * rigidity);
  EXPECT_NEAR(heavy_elastica(L).drop, linear, 1e-4 * linear);
  EXPECT_LT(heavy_elastica(1).drop, 0.9 * density * g / (8 * rigidity));
}

// From the horizontal to rest: within 1 % of the drop with four cells, and falling nearly as the square of their length.
TEST(Elastica, StripComesToItsShape) {
  std::vector<double> errors;
  for (const auto& [n, substeps, iterations] : {std::tuple(4, 8, 100), std::tuple(8, 16, 200), std::tuple(12, 24, 250)}) {
    Scene scene = strip(n);
    scene.time.substeps = substeps, scene.solver.iterations = iterations;
    Experiment run(std::move(scene));
    run.steps(substeps * 300);
    EXPECT_LT(run.velocity(n).norm(), 1e-3) << n;
    errors.push_back(error_of(tip_of(run, n), n));
  }
  EXPECT_LT(errors[0], 0.01);
  EXPECT_GT(std::log(errors[0] / errors[1]) / std::log(2), 1.5);
  EXPECT_GT(std::log(errors[1] / errors[2]) / std::log(1.5), 1.2);  // by Newton's method 1.66: here iterations are left over
}

// The same by Newton's method: what is left of the error is the cells', not the solver's.
TEST(Elastica, SpacingAloneIsTheError) {
  std::vector<double> errors;
  for (const int n : {4, 8}) {
    Experiment run(strip(n));
    run.simulation->detect();
    ReferenceSettings settings;
    settings.softening = 1e-9, settings.tolerance = 1e-11;  // links between held nodes have empty rows
    ReferenceStep step;
    for (int k = 0; k < 110; ++k) {
      const double h = k < 50 ? 0.02 : 0.1;
      step = reference_step(run.world(), run.simulation->ties.constraints, run.scene->gravity, h, settings);
      ASSERT_TRUE(step.converged) << n << ' ' << k << ' ' << step.reason;
      advance(run.world(), step, h);
    }
    EXPECT_LT(largest(step.velocity), 1e-7) << n;
    errors.push_back(error_of(tip_of(run, n), n));
  }
  EXPECT_LT(errors[1], 0.003);
  EXPECT_GT(std::log2(errors[0] / errors[1]), 1.5);
}

}  // namespace unibody::small_worlds::elastica_test
