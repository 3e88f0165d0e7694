// The velocity level (Anitescu and Hart 2004), whose rows are linear about the start of the step and take out the share gamma of
// an error of position a step: against its own closed forms.
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <cmath>
#include <numbers>

#include "report/state_hash.hpp"
#include "small_worlds.hpp"

namespace unibody::small_worlds::velocity_level_test {

namespace {

constexpr double h = 0.016, g = 9.8;
const std::string solvers[] = {"accelerated_jacobi", "jacobi", "gauss_seidel"};

Scene at_velocity_level(Scene scene, const std::string& solver, int iterations, double gamma = 0.4) {
  scene.solver.level = Level::velocity, scene.solver.stabilisation = gamma;
  scene.solver.name = solver, scene.solver.iterations = iterations, scene.solver.tolerance = 0;
  scene.gravity = Vec3(0, 0, -g), scene.time.frame = h;
  return scene;
}

double stopping_distance(double speed, double a) {
  const double n = std::floor(speed / a);
  return h * (n * speed - a * n * (n + 1) / 2);
}

}  // namespace

// A ball in the ground: 5 mm become (1 - gamma)^n of that, as long as it still presses on the ground.
TEST(VelocityLevel, PenetrationFallsByItsShareAStep) {
  for (const std::string& solver : solvers)
    for (const double gamma : {0.0, 0.2, 0.4}) {
      Scene scene = at_velocity_level(scene_with(0), solver, 3, gamma);
      add(scene, ball(2, 0.1, Vec3(0, 0, 0.095)));
      add(scene, ground());
      Experiment run(std::move(scene));
      for (int n = 1; n <= 20; ++n) {
        run.step();
        ASSERT_NEAR(run.position(0).z(), 0.1 - 0.005 * std::pow(1 - gamma, n), 1e-14) << solver << ' ' << gamma << ' ' << n;
      }
    }
}

// What takes penetration out is a velocity, and stays one: without gravity the ball leaves at gamma d / h. No bound on that speed
// (recovery_speed) holds at this level.
TEST(VelocityLevel, ABallLeavesAtTheSpeedThatTookItOut) {
  Scene scene = at_velocity_level(scene_with(0), "gauss_seidel", 3);
  scene.gravity = Vec3::Zero();
  add(scene, ball(2, 0.1, Vec3(0, 0, 0.05)));
  add(scene, ground());
  Experiment run(std::move(scene));
  run.steps(10);
  EXPECT_NEAR(run.velocity(0).z(), 0.4 * 0.05 / h, 1e-12);
  EXPECT_NEAR(run.position(0).z(), 0.05 + 10 * 0.4 * 0.05, 1e-12);
}

// With gamma = 1 and frozen gaps a row of a contact is that of the position level without a bound on its speed: the same bits.
TEST(VelocityLevel, OfContactsIsThePositionLevelWhereGammaIsOne) {
  const auto run_of = [](double gamma, const std::string& solver) {
    Scene scene = at_velocity_level(scene_with(0.5), solver, 12, gamma);
    scene.solver.warm_start = 0.3;
    for (int k = 0; k < 6; ++k) add(scene, block(1, Vec3(.2, .2, .2), Vec3(0.03 * (k % 3), 0.01 * k, 0.095 + 0.19 * k)));
    add(scene, ground());
    return scene;
  };
  for (const std::string& solver : solvers) {
    Scene positions = run_of(1, solver);
    positions.solver.level = Level::position, positions.solver.stages = Stages::position;
    positions.solver.recovery_time = positions.solver.recovery_speed = 0;
    Experiment one(run_of(1, solver)), other(std::move(positions)), weak(run_of(0.9, solver));
    one.steps(40), other.steps(40), weak.steps(40);
    const std::uint64_t hash = state_hash(MPI_COMM_SELF, one.world());
    EXPECT_EQ(hash, state_hash(MPI_COMM_SELF, other.world())) << solver;
    EXPECT_NE(hash, state_hash(MPI_COMM_SELF, weak.world())) << solver;
  }
}

// A gap may close within the step, and no further.
TEST(VelocityLevel, AFallingBallComesToLieOnTheGround) {
  Scene scene = at_velocity_level(scene_with(0), "jacobi", 3);
  Body falling = ball(2, 0.1, Vec3(0, 0, 0.15));
  falling.state.velocity = Vec3(0, 0, -4);
  add(scene, falling);
  add(scene, ground());
  Experiment run(std::move(scene));
  run.step();
  EXPECT_NEAR(run.position(0).z(), 0.1, 1e-14);
  EXPECT_NEAR(run.velocity(0).z(), -0.05 / h, 1e-12);
  run.step();
  EXPECT_NEAR(run.position(0).z(), 0.1, 1e-14);
  EXPECT_NEAR(run.velocity(0).z(), 0, 1e-12);
}

// Every step takes mu g h off the speed, in all directions, for a point as for a cube on its four corners.
TEST(VelocityLevel, SlidingBodiesStopWhereCoulombSays) {
  const Body particle = without_turning(ball(1, 0.1, Vec3(0, 0, 0.1))), cube = block(1, Vec3::Ones(), Vec3(0, 0, 0.5));
  for (const std::string& solver : solvers)
    for (const double mu : {0.1, 0.5})
      for (const Body& body : {particle, cube})
        for (int degrees = 0; degrees <= 90; degrees += 15) {
          const bool is_cube = body.properties.shape.kind == ShapeKind::box;
          const double angle = degrees * std::numbers::pi / 180, speed = 5;
          const Vec3 along(std::cos(angle), std::sin(angle), 0);
          Scene scene = at_velocity_level(scene_with(mu), solver, is_cube ? 100 : 50);
          Body moving = body;
          moving.state.velocity = speed * along;
          add(scene, moving);
          add(scene, ground());
          Experiment run(std::move(scene));
          run.steps(static_cast<int>(speed / (mu * g * h)) + 20);
          const Vec3 expected = stopping_distance(speed, mu * g * h) * along;
          EXPECT_LT((run.position(0) - body.state.position - expected).norm(), is_cube ? 1e-6 : 1e-9)
              << solver << ' ' << mu << ' ' << degrees << (is_cube ? " cube" : " particle");
        }
}

// Ten discs above each other, at rest. K Jacobi sweeps turn the rows' residual r into M r, M = (1 - N / P)^K, so that what is
// left of the weight's share 1 - alpha that no old multiplier carries sinks in by x = h / gamma (1 - M)^-1 M u, u = D^T (1 -
// alpha) h g.
TEST(VelocityLevel, SagOfAnUnconvergedStackIsTheClosedForm) {
  constexpr int n = 10, iterations = 20;
  for (const double gamma : {0.2, 0.4, 1.0})
    for (const double alpha : {0.0, 0.4}) {
      Eigen::MatrixXd N = Eigen::MatrixXd::Zero(n, n), step = Eigen::MatrixXd::Identity(n, n);
      for (int i = 0; i < n; ++i) {  // row i: what disc i is above what is below it; masses 1, split by 2 but at the top
        const double sharers = (i < n - 1 ? 2 : 1) + (i > 0 ? 2 : 0);
        N(i, i) = i > 0 ? 2 : 1;
        if (i > 0) N(i, i - 1) = N(i - 1, i) = -1;
        step.row(i) /= sharers;
      }
      const Eigen::MatrixXd once = Eigen::MatrixXd::Identity(n, n) - N * step;
      Eigen::MatrixXd M = Eigen::MatrixXd::Identity(n, n);
      for (int k = 0; k < iterations; ++k) M = once * M;
      Eigen::VectorXd u = Eigen::VectorXd::Zero(n);
      u[0] = (1 - alpha) * h * g;
      const Eigen::VectorXd x = h / gamma * (Eigen::MatrixXd::Identity(n, n) - M).partialPivLu().solve(M * u);

      Scene scene = at_velocity_level(scene_with(0), "jacobi", iterations, gamma);
      scene.planar = true, scene.solver.warm_start = alpha;
      double height = 0;
      for (int k = 0; k < n; ++k) {
        height += (k == 0 ? 0.5 : 1) - x[k];
        add(scene, disc(1, 0.5, Vec3(0, 0, height)));
      }
      add(scene, ground());
      Experiment run(std::move(scene));
      run.steps(1500);
      height = 0;
      for (int k = 0; k < n; ++k) {
        height += (k == 0 ? 0.5 : 1) - x[k];
        EXPECT_NEAR(run.position(k).z(), height, 1e-6 * x.sum()) << "gamma " << gamma << ", alpha " << alpha << ", disc " << k;
      }
    }
}

// A free chain that swings along itself (see warm_start_test.cpp): here c is that of the step's start and counts by gamma only,
//   w' = q (gamma y + w + a l) - gamma y,   l' = w' - w,   y' = y + w',
// which for q near 1 is damped up to a share a of 1 / (1 + gamma), rather than 1/2.
namespace {

constexpr int links = 20, sweeps = 4, mode = 1;
constexpr double amplitude = 1e-3;  // m/s

double mode_at(int node) { return std::cos(std::numbers::pi * mode * node / links); }

struct Mode {
  double gamma, y = 0, w = amplitude, l = 0;
  void step(double share) {
    const double q = std::pow((1 + std::cos(std::numbers::pi * mode / links)) / 2, sweeps);
    const double next = q * (gamma * y + w + share * l) - gamma * y;
    l = next - w, w = next, y += next;
  }
};

Scene swinging_chain(double gamma, double share) {
  Scene scene = scene_from_text("threads:\n  - {points: [[0, 0, 0], [10, 0, 0]], segments: 20, radius: 0.01, mass: 2}\n");
  scene.groups[0].make = [make = scene.groups[0].make](Id k) {
    Body node = make(k);
    node.state.velocity = Vec3(amplitude * mode_at(static_cast<int>(k)), 0, 0);
    return node;
  };
  scene = at_velocity_level(std::move(scene), "jacobi", sweeps, gamma);
  scene.gravity = Vec3::Zero(), scene.solver.warm_start = share;
  return scene;
}

double radius(double gamma, double share) {
  Eigen::Matrix3d map;
  for (int k = 0; k < 3; ++k) {
    Mode unit{gamma, k == 0 ? 1.0 : 0, k == 1 ? 1.0 : 0, k == 2 ? 1.0 : 0};
    unit.step(share);
    map.col(k) << unit.y, unit.w, unit.l;
  }
  return map.eigenvalues().cwiseAbs().maxCoeff();
}

}  // namespace

TEST(VelocityLevel, AWarmStartFollowsTheClosedFormOfASwingingChain) {
  for (const double gamma : {0.4, 1.0})
    for (const double share : {0.0, 0.5, 0.7, 1.0}) {
      Experiment run(swinging_chain(gamma, share));
      Mode expected{gamma};
      for (int n = 0; n < 200 && std::abs(expected.w) < 10 * amplitude; ++n) {
        run.step(), expected.step(share);
        for (int j = 0; j <= links; ++j)
          ASSERT_NEAR(run.velocity(j).x(), expected.w * mode_at(j), 1e-9 * amplitude)
              << "gamma " << gamma << ", share " << share << ", step " << n;
      }
    }
}

TEST(VelocityLevel, SharesUpToOneOverOnePlusGammaAreStable) {
  for (const double gamma : {0.1, 0.2, 0.4, 1.0}) {
    EXPECT_LT(radius(gamma, 0.97 / (1 + gamma)), 1) << gamma;
    EXPECT_GT(radius(gamma, 1.03 / (1 + gamma)), 1) << gamma;
  }
  EXPECT_LT(automatic_velocity_share, 1 / (1 + SolverSettings{}.stabilisation));
  EXPECT_LT(radius(0, 1), 1 + 1e-12);  // without stabilisation all of the old multipliers do no harm
}

// What has a stiffness keeps it, whatever gamma is: the damped oscillator takes the same implicit map as at position level, and a
// weight stretches a joint by m g E, in one iteration or many and in steps of any length.
TEST(VelocityLevel, SpringsAreAsStiffAsTheySay) {
  const double m = 1, k = 100, rho = 0.05, step = 0.01;
  double x = 1, v = 0;
  for (int n = 0; n < 100; ++n) v = (v - step / m * k * x) / (1 + step / m * k * (step + rho)), x += step * v;
  for (const std::string& solver : solvers)
    for (const int iterations : {1, 10}) {
      Scene scene = scene_from_text(
          "threads:\n  - {points: [[0, 0, 0], [5, 0, 0]], segments: 1, radius: 0.01, mass: 2, pins: [{node: 0}],\n"
          "     stretch: {stiffness: 100, damping: 0.05}}\n");
      scene.groups[0].make = [make = scene.groups[0].make](Id i) {
        Body node = make(i);
        if (i == 1) node.state.position.x() = 6;
        return node;
      };
      scene = at_velocity_level(std::move(scene), solver, iterations);
      scene.gravity = Vec3::Zero(), scene.time.frame = step;
      ASSERT_EQ(scene.body(1).properties.mass, m);
      Experiment run(std::move(scene));
      run.steps(100);
      EXPECT_NEAR(run.position(1).x() - 5, x, 2e-12) << solver << ' ' << iterations;
      EXPECT_NEAR(run.velocity(1).x(), v, 2e-12) << solver << ' ' << iterations;

      for (const double length : {0.004, 0.016}) {
        Scene hung = scene_from_text(
            "bodies:\n  - {name: ball, shape: {sphere: {radius: 0.1}}, mass: 3}\n"
            "joints:\n  - {type: ball, bodies: [ball, world], anchor: [0, 0, 0], compliance: 1.0e-4, damping: 0.1}\n");
        hung = at_velocity_level(std::move(hung), solver, iterations);
        hung.time.frame = length;
        Experiment weight(std::move(hung));
        weight.seconds(8);
        EXPECT_NEAR(weight.position(0).z(), -3 * g * 1e-4, 1e-9) << solver << ' ' << iterations << ' ' << length;
      }
    }
}

// Stiff joints, limits, links and ties that start open, without gravity: the error falls by gamma a step.
TEST(VelocityLevel, OpenConstraintsCloseByTheirShareAStep) {
  struct Case {
    const char* text;
    Id body;
    double error;  // m, along x at the start
  };
  const Case cases[] = {
      {"bodies:\n  - {name: a, shape: {sphere: {radius: 0.1}}, mass: 3, position: [0.01, 0, 0]}\n"
       "joints:\n  - {type: ball, bodies: [a, world], anchors: [[0, 0, 0], [0, 0, 0]]}\n",
       0, 0.01},
      {"bodies:\n  - {name: a, shape: {sphere: {radius: 0.1}}, mass: 3, position: [0.01, 0, 0]}\n"
       "joints:\n  - {type: slider, bodies: [a, world], anchors: [[0, 0, 0], [0, 0, 0]], axis: [1, 0, 0], limits: [-1, 0]}\n",
       0, 0.01},
      {"threads:\n  - {points: [[-1, 0, 0], [0, 0, 0]], segments: 1, radius: 0.01, mass: 2, pins: [{node: 0}]}\n", 1, 0.01},
  };
  for (const std::string& solver : solvers)
    for (const Case& c : cases) {
      Scene scene = scene_from_text(c.text);
      if (c.body == 1)
        scene.groups[0].make = [make = scene.groups[0].make](Id i) {
          Body node = make(i);
          if (i == 1) node.state.position.x() = 0.01;
          return node;
        };
      scene = at_velocity_level(std::move(scene), solver, 400);  // a limit shares its masses with the joint
      scene.gravity = Vec3::Zero();
      const bool pulls_only = std::string(c.text).find("limits") != std::string::npos;
      Experiment run(std::move(scene));
      for (int n = 1; n <= 10; ++n) {
        run.step();
        // A limit lets the body go on with the speed of the first step.
        const double left = pulls_only ? c.error * (1 - 0.4 * n) : c.error * std::pow(0.6, n);
        ASSERT_NEAR(run.position(c.body).x(), left, 1e-14) << solver << ", step " << n << '\n' << c.text;
      }
    }
}

// Boxes and balls of mixed masses fly at each other, ties between some: no solver changes a momentum.
TEST(VelocityLevel, MomentumOfAClosedSystem) {
  for (const std::string& solver : solvers) {
    Scene scene = at_velocity_level(scene_with(0.5), solver, 10);
    scene.gravity = Vec3::Zero();
    for (int k = 0; k < 12; ++k) {
      const Vec3 at = 0.3 * Vec3(k % 2 - 0.5, k / 2 % 2 - 0.5, k / 4 - 1);
      Body b = k % 3 ? block(1 + k, Vec3(.2, .15, .25), at, Quat(1, 0.1 * k, 0.2, 0).normalized()) : ball(0.5, 0.1, at);
      b.state.velocity = -5 * at, b.state.angular_velocity = Vec3(1, k - 6, 2);
      add(scene, b);
    }
    Experiment run(std::move(scene));
    double size = 0;
    for (Id k = 0; k < 12; ++k) size += run.world().properties[run.slot(k)].mass * run.velocity(k).norm();
    const Vec3 p = run.momentum(), L = run.angular_momentum();
    std::size_t touching = 0;
    for (int n = 0; n < 60; ++n) {
      run.step();
      touching += run.simulation->history.contacts().points.size();
    }
    EXPECT_GT(touching, 100u);
    EXPECT_LT((run.momentum() - p).norm(), 1e-12 * size) << solver;
    EXPECT_LT((run.angular_momentum() - L).norm(), 1e-11 * size) << solver;
  }
}

}  // namespace unibody::small_worlds::velocity_level_test
