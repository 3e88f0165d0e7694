// Impacts on faces and edges of sheets and threads bounce by Newton's hypothesis and keep momentum.
#include <gtest/gtest.h>

#include <cmath>

#include "small_worlds.hpp"

namespace unibody::small_worlds::surface_restitution_test {

namespace {

const std::string solver_list[] = {"accelerated_jacobi", "gauss_seidel", "jacobi"};

std::string solver_text(const std::string& name) { return "solver: {name: " + name + ", iterations: 400, tolerance: 0}\n"; }

// Frictionless, weightless, of one material with restitution e.
std::string world_text(const std::string& solver, double e, double step) {
  return "time: {frame: " + std::to_string(step) +
         "}\ngravity: [0, 0, 0]\nmaterials: {m: {friction: 0, restitution: " + std::to_string(e) + "}}\n" + solver_text(solver);
}

constexpr const char* sheet = "cloths:\n  - grid: {size: [1, 1], nodes: [2, 2]}\n    mass: 0.8\n    thickness: 0.02\n";

}  // namespace

// A ball hits one face of a free sheet of two: J = (1 + e) v / (1/M + sum w_k^2 / m_k), shared out by the weights w of its
// corners.
TEST(SurfaceRestitution, BallAndFreeFacePartAtTheirRestitution) {
  const double mass = 0.5, radius = 0.1, v = 2, h = 1e-4;
  for (const std::string& solver : solver_list)
    for (const double e : {0.0, 0.4, 1.0}) {
      Scene scene = scene_from_text(world_text(solver, e, h) + sheet);
      const Vec3 at(0.2, 0.05, 0);
      add(scene, ball(mass, radius, at + Vec3(0, 0, radius + 0.01)));
      Experiment run(std::move(scene));
      const Id id = 4;
      run.world().velocity[run.slot(id)] = Vec3(0, 0, -v);
      Vec3 before[4];
      for (Id k = 0; k < 4; ++k) before[k] = run.position(k);
      run.step();
      ASSERT_EQ(run.simulation->contacts.surface.size(), 1u);
      const SurfaceContact c = run.simulation->contacts.surface[0];
      double effective = 1 / mass, parting = run.velocity(id).z(), momentum = mass * run.velocity(id).z();
      for (std::size_t k = 1; k < 4; ++k) {
        const auto slot = static_cast<std::size_t>(c.slots[k]);
        effective += c.weights[k] * c.weights[k] / run.world().properties[slot].mass;
        parting += c.weights[k] * run.velocity(c.ids[k]).z();
      }
      for (Id k = 0; k < 4; ++k) momentum += run.world().properties[run.slot(k)].mass * run.velocity(k).z();
      // The links see how the step turned them, to second order: a speed of h v^2 / L in all.
      const double turning = 4 * h * v * v;
      EXPECT_NEAR(parting, e * v, turning) << solver << ' ' << e;
      EXPECT_NEAR(run.velocity(id).z(), -v + (1 + e) * v / effective / mass, turning) << solver << ' ' << e;
      EXPECT_NEAR(momentum, -mass * v, 1e-12) << solver << ' ' << e;
    }
}

// Two threads of one segment cross at their middles: edge against edge, equal masses.
TEST(SurfaceRestitution, CrossedThreadsExchangeTheirVelocities) {
  const double v = 2, h = 0.01;
  for (const std::string& solver : solver_list)
    for (const double e : {0.0, 0.6, 1.0}) {
      Scene scene = scene_from_text(world_text(solver, e, h) +
                                    "threads:\n  - {points: [[-0.5, 0, 0], [0.5, 0, 0]], segments: 1, radius: 0.02, mass: 0.3}\n"
                                    "  - {points: [[0, -0.5, 0.04], [0, 0.5, 0.04]], segments: 1, radius: 0.02, mass: 0.3}\n");
      Experiment run(std::move(scene));
      for (Id k : {2, 3}) run.world().velocity[run.slot(k)] = Vec3(0, 0, -v);
      run.step();
      for (Id k = 0; k < 4; ++k)
        EXPECT_NEAR(run.velocity(k).z(), k < 2 ? -0.5 * (1 + e) * v : -0.5 * (1 - e) * v, 1e-9) << solver << ' ' << e;
    }
}

// The tops of a ball's flights over a pinned sheet fall as e^2, and it comes to rest: slow impacts do not bounce.
TEST(SurfaceRestitution, BallOnAPinnedSheetComesToRest) {
  const double e = 0.6, radius = 0.1, fall = 0.5;
  for (const std::string solver : {"accelerated_jacobi", "gauss_seidel"}) {
    Scene scene = scene_from_text("materials: {m: {friction: 0.5, restitution: 0.6}}\nsolver: {name: " + solver + "}\n" + sheet +
                                  "    pins: [{node: [0, 0]}, {node: [0, 1]}, {node: [1, 0]}, {node: [1, 1]}]\n");
    scene.time.substeps = 32;
    add(scene, ball(1, radius, Vec3(0.2, 0.05, radius + 0.01 + fall)));
    Experiment run(std::move(scene));
    double before = 0;
    std::vector<double> tops;
    while (tops.size() < 3 && run.position(4).z() > -1) {
      run.step();
      const double v = run.velocity(4).z();
      if (v <= 0 && before > 0) tops.push_back(run.position(4).z() - radius - 0.01);
      before = v;
    }
    ASSERT_EQ(tops.size(), 3u) << solver;
    for (std::size_t n = 0; n < 3; ++n) {
      const double top = fall * std::pow(e, 2.0 * static_cast<double>(n + 1));
      EXPECT_NEAR(tops[n], top, 0.03 * top) << solver << ' ' << n;  // a step's fall before the impact is lost: 2 h g / v
    }
    run.seconds(4);
    EXPECT_LT(run.velocity(4).norm(), 1e-6) << solver;
    EXPECT_NEAR(run.position(4).z(), radius + 0.01, 1e-3) << solver;
  }
}

}  // namespace unibody::small_worlds::surface_restitution_test
