// Two free bodies that move further in a step than their size, beside each other's centre: the impulse is that of the moment in
// which they touch, and takes all of the speed at which they close.
#include <gtest/gtest.h>

#include <cmath>

#include "small_worlds.hpp"

namespace unibody::small_worlds::fast_impact_test {

namespace {

constexpr double h = 0.016, beside = 0.036, radius = 0.05;

struct Hit {
  double time;  // s
  Vec3 normal;  // from the second to the first
};

// Of two round bodies, the first coming along x from `ahead` before where it touches the second.
Hit hit_of(double speed, double ahead) {
  return {ahead / speed, Vec3(-std::sqrt(4 * radius * radius - beside * beside), 0, -beside) / (2 * radius)};
}

Scene two(const Body& round, double speed, double ahead, double restitution, const std::string& solver) {
  Scene scene = scene_with(0);
  scene.gravity = Vec3::Zero();
  scene.pairs[PairValue::restitution] = {restitution};
  scene.planar = round.properties.shape.kind == ShapeKind::disc;
  scene.solver.name = solver, scene.solver.tolerance = 0;
  Body first = round;
  first.state.position = 2 * radius * hit_of(speed, ahead).normal - Vec3(ahead, 0, 0), first.state.velocity = Vec3(speed, 0, 0);
  add(scene, first), add(scene, round);
  return scene;
}

}  // namespace

class FastImpact : public testing::TestWithParam<const char*> {};

TEST_P(FastImpact, WithoutFrictionTurnsNothing) {
  for (const Body& round : {ball(1, radius, Vec3::Zero()), disc(1, radius, Vec3::Zero())})
    for (const double speed : {8., 20., 100., 1000.}) {
      const double ahead = 0.4 * speed * h;
      const Hit hit = hit_of(speed, ahead);
      Experiment run(two(round, speed, ahead, 0, GetParam()));
      run.step();
      const Vec3 impulse = -0.5 * speed * hit.normal.x() * hit.normal;
      EXPECT_LT((run.velocity(0) - Vec3(speed, 0, 0) - impulse).norm(), 1e-9 * speed) << speed;
      EXPECT_LT((run.velocity(1) + impulse).norm(), 1e-9 * speed) << speed;
      for (const Id id : {0, 1}) EXPECT_LT(run.state(id).angular_velocity.norm(), 1e-9 * speed / radius) << speed;
      EXPECT_GT((run.position(0) - run.position(1)).norm(), 2 * radius - 1e-9 * speed * h) << speed;
      run.steps(3);
      const Vec3 apart = run.position(0) - run.position(1);
      EXPECT_GT(apart.dot(run.velocity(0) - run.velocity(1)), -1e-6 * speed * radius) << speed << ": still closing";
    }
}

TEST_P(FastImpact, BouncesWithoutLossOrTurning) {
  for (const double speed : {20., 200.}) {
    const double ahead = 0.4 * speed * h;
    const Vec3 normal = hit_of(speed, ahead).normal;
    Experiment run(two(ball(1, radius, Vec3::Zero()), speed, ahead, 1, GetParam()));
    run.step();
    const Vec3 impulse = -speed * normal.x() * normal;  // equal masses: the closing velocity is exchanged
    EXPECT_LT((run.velocity(0) - Vec3(speed, 0, 0) - impulse).norm(), 1e-9 * speed) << speed;
    EXPECT_LT(run.state(0).angular_velocity.norm(), 1e-9 * speed / radius) << speed;
    EXPECT_NEAR(run.kinetic_energy(), 0.5 * speed * speed, 1e-9 * speed * speed) << speed;
  }
}

// A plate takes the ball's impulse where it is hit: momentum, spin and the speed of the place by its effective mass.
TEST_P(FastImpact, OfABallOnAFreePlateBesideItsCentre) {
  for (const double speed : {30., 100., 1000.}) {
    const double ahead = 0.4 * speed * h, arm = 0.2;
    Scene scene = scene_with(0);
    scene.gravity = Vec3::Zero();
    Body plate = block(4, Vec3(1, 1, 0.01), Vec3::Zero());
    Body shot = ball(1, radius, Vec3(arm, 0, 0.005 + radius + ahead));
    shot.state.velocity = Vec3(0, 0, -speed);
    add(scene, plate), add(scene, shot);
    scene.solver.name = GetParam(), scene.solver.tolerance = 0;
    Experiment run(scene);
    run.step();
    const double inertia = plate.properties.inertia.y();
    const double impulse = speed / (1 + 0.25 + arm * arm / inertia);
    EXPECT_NEAR(run.velocity(1).z(), -speed + impulse, 1e-6 * speed) << speed;
    EXPECT_NEAR(run.velocity(0).z(), -impulse / 4, 1e-6 * speed) << speed;
    EXPECT_LT(run.state(1).angular_velocity.norm(), 1e-6 * speed / radius) << speed;
  }
}

INSTANTIATE_TEST_SUITE_P(Solvers, FastImpact, testing::Values("accelerated_jacobi", "gauss_seidel"));

}  // namespace unibody::small_worlds::fast_impact_test
