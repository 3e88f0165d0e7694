// What a warm start of links does to the energy, against the closed form of a chain that swings along itself.
//
// A free chain of N equal links with half masses at its ends has the longitudinal modes cos(j theta), theta = pi k / N. In such a
// mode K Jacobi iterations leave the share q = ((1 + cos theta) / 2)^K of a link's error. With elongation y h, its rate w and the
// last step's correction of the rate l, a step from the share a of the old multipliers is
//   w' = q (y + w + a l) - y,   l' = w' - w,   y' = y + w',
// whose eigenvalues for q near 1 have |z|^2 = 1 - (1 - q) (1 - 2 a) / (1 - a)^2: damped below a = 1/2, growing above it. For what
// the iterations leave is made up by the force of the step before, which lags behind by a h / (1 - a), while implicit Euler is
// ahead by h.
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <numbers>

#include "small_worlds.hpp"

namespace unibody::small_worlds::warm_start_test {
namespace {

constexpr int links = 20, iterations = 4, mode = 1;
constexpr double speed = 1e-3;  // m/s: links stay far from turning over

double mode_at(int node) { return std::cos(std::numbers::pi * mode * node / links); }

Scene swinging_chain(double warm_start) {
  Scene scene = scene_from_text("threads:\n  - {points: [[0, 0, 0], [10, 0, 0]], segments: 20, radius: 0.01, mass: 2}\n");
  scene.groups[0].make = [make = scene.groups[0].make](Id k) {
    Body node = make(k);
    node.state.velocity = Vec3(speed * mode_at(static_cast<int>(k)), 0, 0);
    return node;
  };
  scene.gravity = Vec3::Zero();
  scene.solver.name = "jacobi", scene.solver.iterations = iterations, scene.solver.tolerance = 0;
  scene.solver.warm_start = warm_start;
  return scene;
}

// The mode's amplitudes, in m/s.
struct Mode {
  double y = 0, w = speed, l = 0;
  void step(double share) {
    const double q = std::pow((1 + std::cos(std::numbers::pi * mode / links)) / 2, iterations);
    const double next = q * (y + w + share * l) - y;
    l = next - w, w = next, y += next;
  }
};

TEST(WarmStart, FollowsTheClosedFormOfASwingingChain) {
  for (const double share : {0.0, 0.25, 0.5, 0.6}) {
    Experiment run(swinging_chain(share));
    Mode expected;
    for (int n = 0; n < 400; ++n) {
      run.step(), expected.step(share);
      for (int j = 0; j <= links; ++j)
        ASSERT_NEAR(run.velocity(j).x(), expected.w * mode_at(j), 1e-9 * speed) << "share " << share << ", step " << n;
    }
  }
}

TEST(WarmStart, DampsBelowOneHalfAndGainsEnergyAbove) {
  const auto growth = [](double share) {  // of the greatest speed in 800 steps
    Experiment run(swinging_chain(share));
    double first = 0, last = 0;
    for (int n = 0; n < 1000; ++n) {
      run.step();
      if (n < 200) first = std::max(first, std::abs(run.velocity(0).x()));
      if (n >= 800) last = std::max(last, std::abs(run.velocity(0).x()));
    }
    return last / first;
  };
  const auto predicted = [](double share) {  // by the spectral radius of the map of (y, w, l)
    Eigen::Matrix3d step;
    for (int k = 0; k < 3; ++k) {
      Mode unit{k == 0 ? 1.0 : 0, k == 1 ? 1.0 : 0, k == 2 ? 1.0 : 0};
      unit.step(share);
      step.col(k) << unit.y, unit.w, unit.l;
    }
    return std::pow(step.eigenvalues().cwiseAbs().maxCoeff(), 800);
  };
  for (const double share : {0.0, 0.25, 0.4, 0.55})
    EXPECT_NEAR(std::log(growth(share)) / std::log(predicted(share)), 1, 0.05) << share;
  EXPECT_LT(growth(0.4), 0.1);
  EXPECT_GT(growth(0.55), 10);
}

}  // namespace
}  // namespace unibody::small_worlds::warm_start_test
