// Bodies that touch nothing.
#include <gtest/gtest.h>

#include <cmath>

#include "small_worlds.hpp"

namespace unibody::small_worlds::free_flight_test {

// Implicit Euler's own parabola: v_n = v0 + n h g, x_n = x0 + n h v0 + h^2 g n (n + 1) / 2.
TEST(FreeFlight, IsTheDiscreteParabola) {
  Scene scene = scene_with(0.5);
  scene.time.substeps = 3;
  Body b = ball(2, 0.1, Vec3(1, 2, 30));
  b.state.velocity = Vec3(3, -1, 4);
  add(scene, b);
  b = block(0.7, Vec3(0.3, 0.2, 0.1), Vec3(10, 0, 0));
  b.properties.force = Vec3(0.7, 0, 0.7 * 9.81);  // weightless, with 1 m/s^2 along x
  add(scene, b);
  Experiment run(scene);
  const int n = 500;
  const double h = 0.016 / 3;
  run.steps(n);
  const Vec3 expected = Vec3(1, 2, 30) + n * h * Vec3(3, -1, 4) + scene.gravity * (h * h * n * (n + 1) / 2);
  EXPECT_LT((run.position(0) - expected).norm(), 1e-11);
  EXPECT_LT((run.position(1) - Vec3(10 + h * h * n * (n + 1) / 2, 0, 0)).norm(), 1e-11);
}

TEST(FreeFlight, TorqueTurnsABodyUniformly) {
  Scene scene = scene_with(0.5);
  scene.gravity = Vec3::Zero();
  Body b = ball(1, 0.1, Vec3::Zero());
  b.properties.torque = Vec3(0, 0.02, 0);
  add(scene, b);
  Experiment run(scene);
  run.steps(100);
  const double alpha = 0.02 / (0.4 * 0.01);
  EXPECT_NEAR(run.state(0).angular_velocity.y(), alpha * 1.6, 1e-12);
}

namespace {

Scene tumbling(const Vec3& inertia, const Vec3& spin) {
  Scene scene = scene_with(0.5);
  scene.gravity = Vec3::Zero();
  Body b = block(1, Vec3(1, 1, 1), Vec3::Zero());
  b.properties.inertia = inertia;
  b.state.angular_velocity = spin;
  add(scene, b);
  return scene;
}

}  // namespace

// Spin about the middle axis reverses every 2 K(k) / lambda = 18.851 s (Jacobi's elliptic solution).
TEST(FreeFlight, MiddleAxisReversesWithJacobisPeriod) {
  Experiment run(tumbling(Vec3(1, 2, 3), Vec3(0, 1, 0.01)));
  const double E0 = run.energy();
  const Vec3 L0 = run.angular_momentum();
  std::vector<double> reversals;
  double before = 1;
  for (int k = 0; reversals.size() < 4 && k < 6000; ++k) {
    run.step();
    const BodyState s = run.state(0);
    const double w = (s.orientation.conjugate() * s.angular_velocity).y();
    if (w * before < 0) reversals.push_back((k + 1) * run.h());
    before = w;
    ASSERT_LT((run.angular_momentum() - L0).norm(), 1e-10 * L0.norm());
    ASSERT_NEAR(run.energy(), E0, 1e-10 * E0);
  }
  ASSERT_EQ(reversals.size(), 4u);
  for (std::size_t i = 1; i < 4; ++i) EXPECT_NEAR(reversals[i] - reversals[i - 1], 18.851, 0.01 * 18.851);
}

TEST(FreeFlight, FastTumblingKeepsEnergyAndMomentum) {
  Experiment run(tumbling(Vec3(1, 2, 3), Vec3(8, 5, -12)));  // 0.24 rad a step
  const double E0 = run.energy();
  const Vec3 L0 = run.angular_momentum();
  for (int k = 0; k < 2000; ++k) {
    run.step();
    ASSERT_NEAR(run.energy(), E0, 1e-12 * E0 * (k + 1));
    ASSERT_LT((run.angular_momentum() - L0).norm(), 1e-12 * L0.norm() * (k + 1));
  }
  EXPECT_GT((run.state(0).angular_velocity - Vec3(8, 5, -12)).norm(), 0.1);  // it does tumble
}

// A rod that tumbles fast at a step far too long: finite, and still no energy gained.
TEST(FreeFlight, LongStepsGainNoEnergy) {
  Scene scene = tumbling(Vec3(0.01, 1, 1), Vec3(60, 20, 5));
  scene.time.frame = 0.1;
  Experiment run(scene);
  const double E0 = run.energy();
  for (int k = 0; k < 500; ++k) {
    run.step();
    ASSERT_LE(run.energy(), E0 * (1 + 1e-9)) << "step " << k;
  }
}

TEST(FreeFlight, QuaternionsStayUnit) {
  Experiment run(tumbling(Vec3(1, 2, 2.5), Vec3(30, -20, 10)));
  run.steps(3000);
  EXPECT_NEAR(run.state(0).orientation.norm(), 1, 1e-15);
}

}  // namespace unibody::small_worlds::free_flight_test
