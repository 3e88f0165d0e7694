// Friction after the solve: bodies brake as they should, a step late, and creep where they should stick.
#include "solve/friction_postprocess.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "constraints/dense_system.hpp"
#include "constraints/random_bench.hpp"

namespace unibody::small_worlds::friction_postprocess_test {

namespace {

constexpr double h = 0.016, g = 9.8, v0 = 5;
const std::string solver_list[] = {"accelerated_jacobi", "jacobi", "gauss_seidel"};
constexpr Stages stages_list[] = {Stages::two, Stages::together, Stages::position};

// Gravity leans in the x-z plane: downhill is +x.
Scene plane_scene(const Body& body, double mu, double tangent, FrictionModel model = FrictionModel::postprocess) {
  Scene scene = scene_with(mu);
  const double angle = std::atan(tangent);
  scene.gravity = g * Vec3(std::sin(angle), 0, -std::cos(angle));
  scene.solver.friction = model, scene.solver.tolerance = 0;
  add(scene, body);
  add(scene, ground());
  return scene;
}

Body thrown(Body body, const Vec3& velocity) {
  body.state.velocity = velocity;
  return body;
}

const Body particle = without_turning(ball(1, 0.1, Vec3(0, 0, 0.1)));
const Body cube = block(1, Vec3(1, 1, 1), Vec3(0, 0, 0.5));

// Each step moves with the speed that the one before it left: explicit Euler of a body that brakes by a = mu g h a step.
double stopping_distance(double a) {
  const double n = std::floor(v0 / a);
  return h * ((n + 1) * v0 - a * n * (n + 1) / 2);
}

Vec3 travel(Experiment& run, Id id, double mu) {
  const Vec3 from = run.position(id);
  run.steps(static_cast<int>(v0 / (mu * g * h)) + 20);
  return run.position(id) - from;
}

// In plain algebra: what the post-processing adds to the velocities, and how many points slide on and how many do not.
struct Expected {
  Eigen::VectorXd change;
  std::int64_t sliding = 0, sticking = 0;
};
Expected expected_change(const Bench& bench, const Dense& dense, const std::vector<ContactBatch::Impulse>& solved) {
  Expected expected{Eigen::VectorXd::Zero(dense.u.size())};
  std::vector<int> sharers(bench.world.size(), 0);
  for (const Manifold& m : bench.contacts.manifolds)
    for (std::uint32_t k = m.first; k < m.first + m.count; ++k)
      if (m.friction * solved[k].n > 0)
        for (const Slot s : {m.slot_a, m.slot_b}) ++sharers[static_cast<std::size_t>(s)];
  for (const Manifold& m : bench.contacts.manifolds)
    for (std::uint32_t k = m.first; k < m.first + m.count; ++k) {
      const double limit = m.friction * solved[k].n;
      if (limit <= 0) continue;
      const Eigen::Vector2d slip = dense.D.middleRows<2>(3 * k + 1) * dense.u;
      const Eigen::VectorXd along = dense.D.middleRows<2>(3 * k + 1).transpose() * slip.normalized();
      double w = 0;
      for (const Slot s : {m.slot_a, m.slot_b})
        w += sharers[static_cast<std::size_t>(s)] *
             along.segment<6>(6 * s).dot(dense.W.block<6, 6>(6 * s, 6 * s) * along.segment<6>(6 * s));
      expected.change -= dense.W * along * std::min(limit, slip.norm() / w);
      ++(limit * w <= slip.norm() ? expected.sliding : expected.sticking);
    }
  return expected;
}

double kinetic_energy(const Bench& bench, const Dense& dense, const Eigen::VectorXd& u) {
  double energy = 0;
  for (std::size_t b = 0; b < bench.world.homes; ++b) {
    const auto i = 6 * static_cast<Eigen::Index>(b);
    energy += 0.5 * u.segment<6>(i).dot(dense.W.block<6, 6>(i, i).inverse() * u.segment<6>(i));
  }
  return energy;
}

}  // namespace

TEST(FrictionPostprocess, ParticleStopsAStepLateInEveryDirection) {
  for (const double mu : {0.1, 0.3, 0.5, 1.0})
    for (const double degrees : {0, 30, 45, 90}) {
      const double angle = degrees * std::numbers::pi / 180, d = stopping_distance(mu * g * h);
      const Vec3 direction(std::cos(angle), std::sin(angle), 0);
      Experiment run(plane_scene(thrown(particle, v0 * direction), mu, 0));
      EXPECT_LT((travel(run, 0, mu) - d * direction).norm(), 1e-9) << "mu " << mu << " at " << degrees << " degrees";
      EXPECT_LT(run.velocity(0).norm(), 1e-14);
      EXPECT_NEAR(d, v0 * v0 / (2 * mu * g), h * v0);
    }
}

TEST(FrictionPostprocess, CubeBrakesLikeAParticleWithEverySolver) {
  for (const std::string& solver : solver_list)
    for (const Stages stages : stages_list) {
      Scene scene = plane_scene(thrown(cube, Vec3(v0, 0, 0)), 0.5, 0);
      scene.solver.name = solver, scene.solver.stages = stages, scene.solver.iterations = 200;
      Experiment run(scene);
      run.steps(40);
      EXPECT_NEAR(run.velocity(0).x(), v0 - 40 * 0.5 * g * h, 1e-3) << solver;
      EXPECT_EQ(run.last.sliding, 4) << solver;
    }
}

// v' = 5 v / 7: it ends up rolling.
TEST(FrictionPostprocess, ThrownBallEndsUpRolling) {
  Experiment run(plane_scene(thrown(ball(2, 0.1, Vec3(0, 0, 0.1)), Vec3(1.4, 0, 0)), 0.3, 0));
  run.seconds(1);
  EXPECT_NEAR(run.velocity(0).x(), 1, 1e-9);
  EXPECT_NEAR(run.state(0).angular_velocity.y(), 10, 1e-8);
}

// Every step starts at rest, gains g sin(angle) h and moves with it; then friction takes it away.
TEST(FrictionPostprocess, ParticleCreepsWhereItShouldStick) {
  const double mu = 0.5, tangent = 0.95 * mu, creep = g * std::sin(std::atan(tangent)) * h * h;
  for (const std::string& solver : solver_list)
    for (const Stages stages : stages_list) {
      Scene scene = plane_scene(particle, mu, tangent);
      scene.solver.name = solver, scene.solver.stages = stages;
      Experiment run(scene);
      run.steps(312);
      EXPECT_NEAR(run.position(0).x(), 312 * creep, 1e-9) << solver;
      EXPECT_LT(run.velocity(0).norm(), 1e-12) << solver;
      EXPECT_EQ(run.last.sliding, 0);
      scene.solver.friction = FrictionModel::disc;
      Experiment held(scene);
      held.steps(312);
      EXPECT_LT(std::abs(held.position(0).x()), 1e-6) << solver;
    }
}

// As long as friction reverses no slip, a step moves at least as far as gravity alone takes a body that starts at rest.
TEST(FrictionPostprocess, BoxCreepsWhereItShouldStick) {
  const double mu = 0.5, tangent = 0.95 * mu, creep = g * std::sin(std::atan(tangent)) * h;
  for (const std::string& solver : {solver_list[0], solver_list[2]})
    for (const auto model : {FrictionModel::postprocess, FrictionModel::disc}) {
      Scene scene = plane_scene(cube, mu, tangent, model);
      scene.solver.name = solver;
      Experiment run(scene);
      run.seconds(5);  // the first steps start cold
      const double settled = run.position(0).x();
      run.seconds(5);
      const double moved = run.position(0).x() - settled;
      if (model == FrictionModel::postprocess)
        EXPECT_GT(moved, 0.999 * 5 * creep) << solver;
      else
        EXPECT_LT(std::abs(moved), 1e-6) << solver;
    }
}

// Without friction it is no model at all, to the last bit.
TEST(FrictionPostprocess, LeavesSmoothBodiesAlone) {
  for (const std::string& solver : solver_list) {
    const auto end = [&](FrictionModel model) {
      Scene scene = plane_scene(thrown(cube, Vec3(1, 2, -1)), 0, 0.3, model);
      scene.solver.name = solver;
      Experiment run(scene);
      run.steps(100);
      return run.state(0);
    };
    const BodyState left = end(FrictionModel::postprocess), right = end(FrictionModel::none);
    EXPECT_EQ(left.position, right.position) << solver;
    EXPECT_EQ(left.velocity, right.velocity) << solver;
    EXPECT_EQ(left.angular_velocity, right.angular_velocity) << solver;
  }
}

TEST(FrictionPostprocess, IsWhatPlainAlgebraGives) {
  std::int64_t sliding = 0, sticking = 0;
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    const auto bench = random_bench(seed, FrictionModel::postprocess);
    bench->build_for_jacobi();
    bench->start({Stage::Kind::position, h, h, 0.25});
    accelerated_jacobi(bench->system, bench->exchange, 40, 0);
    const Dense dense(*bench);
    const auto solved = impulses_of(*bench);
    const Expected expected = expected_change(*bench, dense, solved);
    const std::int64_t counted = postprocess_friction(bench->world, bench->contacts, bench->system, bench->exchange);
    const Eigen::VectorXd after = Dense::velocities(*bench);
    EXPECT_LT((after - dense.u - expected.change).norm(), 1e-12 * (1 + expected.change.norm())) << "seed " << seed;
    EXPECT_LT(kinetic_energy(*bench, dense, after), kinetic_energy(*bench, dense, dense.u)) << "seed " << seed;
    EXPECT_EQ(counted, expected.sliding);
    for (std::size_t b = 0; b < bench->world.size(); ++b) {
      const auto moving = Eigen::Map<const Vec3>(bench->system.moving[b].v);
      EXPECT_EQ(Vec3(dense.u.segment<3>(6 * static_cast<Eigen::Index>(b))), Vec3(moving));
    }
    sliding += counted, sticking += expected.sticking;
  }
  EXPECT_GT(sliding, 30);
  EXPECT_GT(sticking, 30);
}

namespace {

// A level sheet of one cell, 8 m long and 2 cm thick, and a grain that touches it.
Scene sheet_scene(const std::string& pins, double mu, const Vec3& velocity, double angle) {
  Scene scene = scene_from_text("cloths:\n  - {grid: {size: [8, 8], nodes: [2, 2]}, mass: 1, thickness: 0.02" + pins + "}\n");
  Body grain = thrown(ball(1, 0.05, Vec3(-1.3, 0.4, 0.06)), velocity);
  grain.properties.shape.kind = ShapeKind::particle, grain.properties.inertia = Vec3::Zero();
  add(scene, grain);
  scene.gravity = g * Vec3(std::sin(angle), 0, -std::cos(angle));
  scene.friction = {mu}, scene.solver.tolerance = 0, scene.solver.friction = FrictionModel::postprocess;
  return scene;
}
constexpr Id grain_id = 4;
const std::string pinned = ", pins: [{node: [0, 0]}, {node: [1, 0]}, {node: [0, 1]}, {node: [1, 1]}]";

}  // namespace

TEST(FrictionPostprocess, SheetBrakesAndLetsCreepLikeAPlane) {
  const double mu = 0.5, tangent = 0.95 * mu, angle = std::atan(tangent);
  for (const std::string& solver : solver_list) {
    Scene level = sheet_scene(pinned, mu, Vec3(v0, 0, 0), 0), slope = sheet_scene(pinned, mu, Vec3::Zero(), angle);
    level.solver.name = slope.solver.name = solver;
    Experiment run(level), creeping(slope);
    EXPECT_NEAR(travel(run, grain_id, mu).x(), stopping_distance(mu * g * h), 1e-6) << solver;
    creeping.steps(100);
    EXPECT_NEAR(creeping.position(grain_id).x() + 1.3, 100 * g * std::sin(angle) * h * h, 1e-9) << solver;
  }
}

TEST(FrictionPostprocess, KeepsTheMomentumOfAFreeSheet) {
  Scene scene = sheet_scene("", 0.5, Vec3(2, 1, -1), 0);
  scene.gravity = Vec3::Zero();
  Experiment run(scene);
  const Vec3 before = run.momentum();
  run.step();
  EXPECT_LT((run.momentum() - before).norm(), 1e-13);
  EXPECT_LT(run.velocity(grain_id).x(), 1.9);
}

}  // namespace unibody::small_worlds::friction_postprocess_test
