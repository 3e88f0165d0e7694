// Bodies on sheets and threads, where nothing but faces and edges can hold them, against the mechanics of elementary cases.
#include <gtest/gtest.h>

#include <cmath>

#include "report/surface_report.hpp"
#include "small_worlds.hpp"

namespace unibody::small_worlds::surface_test {

namespace {

constexpr double g = 9.81;

// A sheet of n x n nodes, `side` m long and 2 cm thick, all of them pinned. Its top is at z = 1 cm.
std::string pinned_sheet(int n, double side) {
  std::string pins;
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i)
      pins += (pins.empty() ? "" : ", ") + ("{node: [" + std::to_string(i) + ", " + std::to_string(j)) + "]}";
  const std::string size = std::to_string(side), count = std::to_string(n);
  return "cloths:\n  - grid: {size: [" + size + ", " + size + "], nodes: [" + count + ", " + count +
         "]}\n    mass: 1\n    thickness: 0.02\n    pins: [" + pins + "]\n";
}

// The sheet is level and gravity leans: downhill is +x.
Experiment on_slope(const Body& body, double mu, double tangent, const std::string& solver, int nodes = 2, double side = 8,
                    int iterations = 50) {
  Scene scene = scene_from_text(pinned_sheet(nodes, side));
  const double angle = std::atan(tangent);
  scene.gravity = g * Vec3(std::sin(angle), 0, -std::cos(angle));
  scene.friction = {mu}, scene.solver.name = solver, scene.solver.tolerance = 0, scene.solver.iterations = iterations;
  add(scene, body);
  return Experiment(std::move(scene));
}

Body grain(double mass, double radius, const Vec3& position) {
  Body b = ball(mass, radius, position);
  b.properties.shape.kind = ShapeKind::particle, b.properties.inertia = Vec3::Zero();
  return b;
}

const std::string solver_list[] = {"accelerated_jacobi", "gauss_seidel"};
constexpr Id body4 = 4;  // after the four nodes of a sheet of one cell

}  // namespace

// Nodes are 10 radii apart: between them it rests on faces and edges alone.
TEST(Surface, BallRestsBetweenTheNodesOfASheet) {
  for (const std::string& solver : solver_list)
    for (const Vec3& at : {Vec3(0.31, 0.17, 0), Vec3(0.5, 0.5, 0), Vec3(0, 0.4, 0)}) {
      const double radius = 0.1;
      Experiment run = on_slope(ball(3, radius, at + Vec3(0, 0, radius + 0.01 + 0.05)), 0.5, 0, solver, 5, 4);
      run.seconds(2);
      const Id id = 25;
      EXPECT_NEAR(run.position(id).z(), radius + 0.01, 1e-6) << solver;
      EXPECT_LT((run.position(id) - at).head<2>().norm(), 1e-6) << solver;
      const double before = run.position(id).z();
      run.seconds(2);
      EXPECT_NEAR(run.position(id).z(), before, 1e-9) << solver;
      EXPECT_LT(run.velocity(id).norm(), 1e-9) << solver;
      EXPECT_EQ(run.last.guard.pairs, 0);
    }
}

// It doesn't sink. Without memory from step to step friction needs more than the usual iterations not to let it creep.
TEST(Surface, BoxRestsOnASheet) {
  for (const std::string& solver : solver_list)
    for (const int iterations : {50, 500})
      for (const int nodes : {2, 9}) {
        const Vec3 edges(0.2, 0.3, 0.1);
        const Quat turn(Eigen::AngleAxisd(0.3, Vec3::UnitZ()));
        Experiment run =
            on_slope(block(2, edges, Vec3(0.33, 0.21, 0.05 + 0.01 + 0.02), turn), 0.5, 0, solver, nodes, 4, iterations);
        const Id id = nodes * nodes;
        run.seconds(1);
        EXPECT_NEAR(run.position(id).z(), 0.06, iterations == 50 ? 1e-4 : 1e-6) << solver;
        EXPECT_LT(run.state(id).orientation.angularDistance(turn), iterations == 50 ? 5e-3 : 1e-5) << solver;
        const Vec3 before = run.position(id);
        run.seconds(1);
        EXPECT_NEAR(run.position(id).z(), before.z(), 1e-6) << solver << ' ' << nodes;
        if (iterations == 500) {
          EXPECT_LT((run.position(id) - before).norm(), 1e-6) << solver << ' ' << nodes;
        }
        EXPECT_EQ(run.last.guard.pairs, 0);
      }
}

// A grain or a box sticks below the angle of friction; beyond it they slide with a = g (sin - mu cos).
TEST(Surface, StickAndSlipOnAnInclinedSheet) {
  const double mu = 0.4;
  for (const std::string& solver : solver_list)
    for (const bool is_box : {false, true})
      for (const double factor : {0.9, 1.1}) {
        const Body body = is_box ? block(1, Vec3(0.3, 0.3, 0.1), Vec3(-1, 0.2, 0.06)) : grain(1, 0.05, Vec3(-1, 0.2, 0.06));
        Experiment run = on_slope(body, mu, factor * mu, solver, 2, 8, 500);
        run.steps(50);
        const double x = run.position(body4).x(), v = run.velocity(body4).x();
        run.steps(50);
        if (factor < 1) {
          EXPECT_NEAR(run.position(body4).x(), -1, 1e-6) << solver << ' ' << is_box;
          EXPECT_NEAR(run.position(body4).x(), x, 1e-8) << solver << ' ' << is_box;
        } else {
          const double angle = std::atan(factor * mu), gained = g * (std::sin(angle) - mu * std::cos(angle)) * 50 * run.h();
          EXPECT_NEAR(run.velocity(body4).x() - v, gained, 1e-5 * gained) << solver << ' ' << is_box;
          EXPECT_GE(run.last.sliding, 1);
        }
        EXPECT_NEAR(run.position(body4).z(), 0.06, 1e-6);
      }
}

// A ball rolls: a = 5/7 g sin, and its arm ends on the face's plane, half a thickness below it: (5/7 with R = r + 1 cm).
TEST(Surface, BallRollsDownAnInclinedSheet) {
  const double tangent = 0.3, angle = std::atan(tangent), r = 0.1, R = r + 0.01;
  Experiment run = on_slope(ball(1, r, Vec3(-2, 0.2, R)), 0.6, tangent, "accelerated_jacobi");
  run.steps(80);
  const double a = g * std::sin(angle) / (1 + 0.4 * r * r / (R * R)), v = a * 80 * run.h();
  EXPECT_NEAR(run.velocity(body4).x(), v, 1e-6 * v);
  EXPECT_NEAR(run.state(body4).angular_velocity.y(), v / R, 1e-6 * v / R);
}

// A ball across a thread between two pins, with nothing but the thread's one segment below it: it does not fall through.
TEST(Surface, BarRestsOnTwoThreads) {
  Scene scene = scene_from_text(R"(
threads:
  - {points: [[-1, -1, 0], [-1, 1, 0]], segments: 1, radius: 0.02, mass: 1, pins: [{node: 0}, {node: 1}]}
  - {points: [[1, -1, 0], [1, 1, 0]], segments: 1, radius: 0.02, mass: 1, pins: [{node: 0}, {node: 1}]}
)");
  add(scene, block(2, Vec3(3, 0.1, 0.1), Vec3(0.1, 0.2, 0.09)));
  Experiment run(std::move(scene));
  run.seconds(2);
  EXPECT_NEAR(run.position(4).z(), 0.07, 1e-4);
  EXPECT_EQ(run.last.guard.pairs, 0);
}

// No gravity, a free cloth: what the ball, box or grain loses the cloth gains, to round-off of the sums over some hundred
// impulses. Implicit Euler takes angular momentum from links that turn: these are too weak to matter.
TEST(Surface, ImpactOnAFreeClothKeepsMomentum) {
  for (const std::string& solver : solver_list)
    for (const int kind : {0, 1, 2}) {
      Scene scene = scene_from_text(R"(
cloths:
  - {grid: {size: [1, 1], nodes: [4, 4]}, mass: 1, thickness: 0.02, links: {stiffness: 1.0e-9}}
gravity: [0, 0, 0]
)");
      scene.solver.name = solver;
      const Vec3 at(0.03, 0.02, 0.2);
      Body b = kind == 0 ? ball(1, 0.06, at) : kind == 1 ? block(1, Vec3(0.1, 0.12, 0.14), at) : grain(1, 0.06, at);
      b.state.velocity = Vec3(0.5, -0.2, -2), b.state.angular_velocity = kind == 2 ? Vec3(Vec3::Zero()) : Vec3(0, 1, 2);
      const Id id = add(scene, b);
      Experiment run(std::move(scene));
      const Vec3 p = run.momentum(), L = run.angular_momentum();
      const double energy = run.kinetic_energy();
      std::int64_t held = 0;
      for (int k = 0; k < 40; ++k) {
        run.step(), held += run.last.guard.pairs;
        ASSERT_LT((run.momentum() - p).norm(), 1e-12) << solver << ' ' << kind;
      }
      EXPECT_EQ(held, 0) << solver << ' ' << kind;
      EXPECT_GT(run.velocity(id).z(), -1.9) << "it has met nothing";
      EXPECT_LT(run.kinetic_energy(), energy);
      // A ball is touched in the cloth's own point. A grain has no arm, so that friction acts a radius off; a box turns unevenly.
      if (kind == 0) {
        EXPECT_LT((run.angular_momentum() - L).norm(), 1e-11) << solver;
      }
    }
}

// A start in overlap by half the thickness comes apart no faster than the bound on recovery, 0.25 m/s, allows.
TEST(Surface, AStartInOverlapDoesNotExplode) {
  for (const std::string& solver : solver_list)
    for (const bool is_box : {false, true}) {
      Scene scene = scene_from_text(R"(
cloths:
  - {grid: {size: [1, 1], nodes: [5, 5]}, mass: 0.3, thickness: 0.02, links: {stiffness: 1000, damping: 0.01}}
gravity: [0, 0, 0]
)");
      scene.solver.name = solver, scene.solver.iterations = 200;
      const Vec3 at(0.06, 0.1, 0.1);
      const Id id = add(scene, is_box ? block(1, Vec3(0.2, 0.2, 0.2), at) : ball(1, 0.1, at));  // 1 cm into the cloth
      Experiment run(std::move(scene));
      double fastest = 0;
      for (int k = 0; k < 60; ++k) {
        run.step();
        for (std::size_t i = 0; i < run.world().homes; ++i) fastest = std::max(fastest, run.world().velocity[i].norm());
      }
      // Twice: the bound is on the speed at which the two part, which nodes of little mass make alone, and springs swing back.
      EXPECT_LT(fastest, 0.5) << solver << ' ' << is_box;
      EXPECT_GT(fastest, 0.05) << "it never came apart";
      EXPECT_GT(run.position(id).z(), 0.1);
      EXPECT_TRUE(run.finite());
    }
}

// Links have no velocity stage: where one is asked for, half of the iterations are for the stage that links have, and not the
// fifth that contacts alone leave it. A box falls deeper into a cloth whose links have too few.
TEST(Surface, AVelocityStageLeavesLinksTheirIterations) {
  const auto lowest = [](const std::string& more) {
    Experiment run(scene_from_text("solver: {stages: two, tolerance: 0, " + more + R"(}
bodies:
  - {shape: {box: {size: [0.2, 0.2, 0.2]}}, mass: 1, position: [0, 0, 0.115]}
cloths:
  - {grid: {size: [1, 1], nodes: [16, 16]}, mass: 0.3, thickness: 0.02, links: {},
     pins: [{node: [0, 0]}, {node: [15, 0]}, {node: [0, 15]}, {node: [15, 15]}]}
)"));
    double least = HUGE_VAL;
    for (int k = 0; k < 125; ++k) run.step(), least = std::min(least, run.position(0).z());
    return least;
  };
  const double converged = lowest("iterations: 1000, velocity_share: 0.5"), half = lowest("iterations: 50"),
               fifth = lowest("iterations: 50, velocity_share: 0.8");
  EXPECT_EQ(half, lowest("iterations: 50, velocity_share: 0.5"));
  EXPECT_LT(converged - half, 0.5 * (converged - fifth));
  EXPECT_LT(half, converged);
}

}  // namespace unibody::small_worlds::surface_test
