// Bodies on a slope: stick, slip, tip and roll at the angles and with the accelerations of elementary mechanics.
#include <gtest/gtest.h>

#include <cmath>

#include "small_worlds.hpp"

namespace unibody::small_worlds::incline_test {

namespace {

constexpr double g = 9.81;

// The plane is level and gravity leans: downhill is +x, so that positions are measured along the slope.
Scene slope(double mu, double tangent) {
  Scene scene = scene_with(mu);
  const double angle = std::atan(tangent);
  scene.gravity = g * Vec3(std::sin(angle), 0, -std::cos(angle));
  return scene;
}

}  // namespace

// The first step is solved to round-off, which leaves the box where it is: from the forces that it has found, no later one, with
// the default iterations and tolerance, may let go. Started cold, steps that stop at the tolerance creep until their
// forces have grown: in all no more than twice as far as the box slides in its first step without friction, h^2 g sin, and no
// farther in the minute after the first second.
TEST(Incline, BoxSticksBelowTheAngleOfFriction) {
  const Vec3 start(0, 0, 0.5);
  for (const std::string solver : {"accelerated_jacobi", "gauss_seidel"})
    for (const bool warm : {true, false}) {
      Scene scene = slope(0.5, 0.95 * 0.5);
      scene.solver.name = solver;
      add(scene, block(1, Vec3(1, 1, 1), start));
      add(scene, ground());
      Experiment run(scene);
      const SolverSettings defaults = run.scene->solver;
      if (warm) run.scene->solver.iterations = 20000, run.scene->solver.tolerance = 0;
      run.simulation->resolve_automatic_settings();
      run.step();
      run.scene->solver = defaults;
      run.simulation->resolve_automatic_settings();
      run.seconds(1);
      const Vec3 settled = run.position(0);
      const double free = g * std::sin(std::atan(0.95 * 0.5)) * run.h() * run.h();  // m
      EXPECT_LT((settled - start).norm(), warm ? 1e-6 : 2 * free) << solver;
      run.seconds(60);
      EXPECT_LT((run.position(0) - settled).norm(), 1e-6) << solver << (warm ? ", warm" : ", cold");
    }
}

// An independent code's figures, of a box on two corners, 60 steps of Jacobi with 50 iterations, cold; along the slope and up
// from it. On the one it sticks, at mu half as large as the other's slope it slides.
TEST(Incline, PublishedFiguresOfStickAndSlip) {
  for (const double tangent : {0.25, 1.0}) {
    Scene scene = slope(0.5, tangent);
    scene.gravity *= 9.8 / g;
    scene.planar = true;
    scene.solver.name = "jacobi", scene.solver.iterations = 50, scene.solver.tolerance = 0;
    scene.solver.stages = Stages::position, scene.solver.warm_start = 0;
    add(scene, block(1, Vec3(1, 1, 1), Vec3(0, 0, 0.5)));
    add(scene, ground());
    Experiment run(scene);
    run.steps(60);
    if (tangent == 1) {
      EXPECT_NEAR(run.velocity(0).x(), 3.3262, 1e-3 * 3.3262);
      continue;
    }
    EXPECT_LT(run.velocity(0).norm(), 1e-4);
    Vec3 force = Vec3::Zero();
    for (const RememberedPoint& p : run.simulation->history.contacts().points) force += p.normal * Vec3::UnitZ() + p.tangential;
    EXPECT_LT((force / 9.8 - Vec3(-.2425, 0, .9701)).norm(), 1e-3);
  }
}

TEST(Incline, TiltedPlaneGivesTheSameAsLeaningGravity) {
  Scene scene = scene_with(0.5);
  const double angle = std::atan(0.95 * 0.5);
  const Quat turn(Eigen::AngleAxisd(angle, Vec3::UnitY()));
  add(scene, block(1, Vec3(1, 1, 1), turn * Vec3(0, 0, 0.5), turn));
  add(scene, ground(Vec3::Zero(), turn * Vec3::UnitZ()));
  scene.solver.tolerance = 0;
  Scene level = slope(0.5, 0.95 * 0.5);
  level.solver.tolerance = 0;
  add(level, block(1, Vec3(1, 1, 1), Vec3(0, 0, 0.5)));
  add(level, ground());
  Experiment run(scene), other(level);
  run.seconds(10), other.seconds(10);
  EXPECT_LT((run.position(0) - turn * other.position(0)).norm(), 1e-9);
  EXPECT_LT((other.position(0) - Vec3(0, 0, 0.5)).norm(), 1e-3);
}

TEST(Incline, BoxSlipsAboveTheAngleOfFriction) {
  for (const std::string solver : {"accelerated_jacobi", "gauss_seidel"}) {
    const double mu = 0.5, angle = std::atan(1.05 * mu), a = g * (std::sin(angle) - mu * std::cos(angle));
    Scene scene = slope(mu, 1.05 * mu);
    scene.solver.name = solver;
    add(scene, block(1, Vec3(1, 1, 1), Vec3(0, 0, 0.5)));
    add(scene, ground());
    Experiment run(scene);
    run.steps(100);  // the first steps start cold
    const double before = run.velocity(0).x(), gained = a * 200 * run.h();
    run.steps(200);
    EXPECT_NEAR(run.velocity(0).x() - before, gained, 1e-3 * gained) << solver;
    EXPECT_NEAR(run.position(0).z(), 0.5, 1e-3) << solver;
  }
}

TEST(Incline, SlabTipsAtItsAspectRatio) {
  const double b = 0.1, H = 0.3;
  for (const double factor : {0.99, 1.01}) {
    Scene scene = slope(2, factor * b / H);
    scene.solver.iterations = 400, scene.solver.tolerance = 0;  // from the first step on: there is 1 % to spare
    add(scene, block(1, Vec3(b, 0.2, H), Vec3(0, 0, H / 2)));
    add(scene, ground());
    Experiment run(scene);
    run.seconds(5);
    const double lean = std::acos(std::min(1.0, (run.state(0).orientation * Vec3::UnitZ()).z()));
    if (factor < 1) {
      EXPECT_LT(lean, 1e-3);
    } else {
      EXPECT_GT(lean, 1.0);
    }
  }
}

// One contact, solved to round-off in each step: the discrete motion is v_n = n h a, exactly.
TEST(Incline, SphereRolls) {
  const double mu = 0.3, tangent = 0.9 * mu * 7 / 2, angle = std::atan(tangent), r = 0.2, a = 5.0 / 7 * g * std::sin(angle);
  Scene scene = slope(mu, tangent);
  scene.solver.tolerance = 0;
  add(scene, ball(3, r, Vec3(0, 0, r)));
  add(scene, ground());
  Experiment run(scene);
  run.steps(200);
  const double v = 200 * run.h() * a;
  EXPECT_NEAR(run.velocity(0).x(), v, 1e-6 * v);
  EXPECT_NEAR(run.state(0).angular_velocity.y(), v / r, 1e-6 * v / r);
  EXPECT_NEAR(run.position(0).x(), a * run.h() * run.h() * 200 * 201 / 2, 1e-6 * v);
}

TEST(Incline, SphereSlipsWhileItRolls) {
  const double mu = 0.3, tangent = 1.1 * mu * 7 / 2, angle = std::atan(tangent), r = 0.2;
  const double a = g * (std::sin(angle) - mu * std::cos(angle)), alpha = 5 * mu * g * std::cos(angle) / (2 * r);
  Scene scene = slope(mu, tangent);
  scene.solver.tolerance = 0;
  add(scene, ball(3, r, Vec3(0, 0, r)));
  add(scene, ground());
  Experiment run(scene);
  run.steps(200);
  const double t = 200 * run.h();
  EXPECT_NEAR(run.velocity(0).x(), a * t, 1e-6 * a * t);
  EXPECT_NEAR(run.state(0).angular_velocity.y(), alpha * t, 1e-6 * alpha * t);
}

// v' = 5 v / 7: a ball thrown along the ground without spin loses two sevenths of its speed, whatever the friction.
TEST(Incline, ThrownBallEndsUpRolling) {
  for (const double mu : {0.1, 0.4}) {
    Scene scene = scene_with(mu);
    scene.solver.tolerance = 0;
    Body b = ball(2, 0.1, Vec3(0, 0, 0.1));
    b.state.velocity = Vec3(1.4, 0, 0);
    add(scene, b);
    add(scene, ground());
    Experiment run(scene);
    run.seconds(3);
    EXPECT_NEAR(run.velocity(0).x(), 1.0, 1e-9);
    EXPECT_NEAR(run.state(0).angular_velocity.y(), 10.0, 1e-8);
  }
}

}  // namespace unibody::small_worlds::incline_test
