// Runs by the solver `newton`: conservation, energy, the statics of one huge step, and the air.
#include <gtest/gtest.h>

#include <cmath>
#include <sstream>

#include "solve/elastic_bench.hpp"
#include "solve/reference.hpp"

namespace unibody::small_worlds {

namespace {

constexpr double young = 1e5, poisson = 0.3;
const std::string law = "density: 1000\n    youngs_modulus: 1.0e5\n    poissons_ratio: 0.3";
const std::string by_newton = "solver: {name: newton}\n";

// 1 m x 0.2 m x 0.2 m, held at one end.
Scene beam(const std::string& cells, double step, double gravity, const std::string& more = "") {
  std::ostringstream head;
  head << "gravity: [0, 0, " << gravity << "]\ntime: {step: " << step << "}\n";
  return scene_from_text(
      head.str() + by_newton +
      block_text("[1, 0.2, 0.2]", cells,
                 "position: [0.5, 0, 0]\n    " + law + "\n    pins: [{within: {min: [0, -1, -1], max: [0, 1, 1]}}]" + more));
}

ElasticMesh mesh_at_rest(const Experiment& run) {
  run.simulation->make_constraints();
  return mesh_of(run.simulation->constraints, run.simulation->world.position, lame(young, poisson));
}

}  // namespace

// Implicit Euler takes angular momentum from what turns: its elastic forces have no moment about the places at the end of the
// step, so that L changes by h sum m v x v_l, and by nothing else.
TEST(Newton, AFreeBlockKeepsItsMomentumAndGainsNoEnergy) {
  Experiment run(scene_from_text(
      "gravity: [0, 0, 0]\n" + by_newton +
      block_text("[0.3, 0.2, 0.2]", "[3, 2, 2]", law + "\n    velocity: [1, 2, -1]\n    angular_velocity: [3, 8, 5]")));
  const ElasticMesh mesh = mesh_at_rest(run);
  testing::Random random(3);
  for (Vec3& x : run.world().position) x += random.vector(-0.01, 0.01);
  const auto energy = [&] { return run.kinetic_energy() + mesh.energy(run.world().position); };
  const Vec3 momentum = run.momentum();
  const double start = energy();
  double before = start;
  for (int k = 0; k < 100; ++k) {
    const std::vector<Vec3> old = run.world().velocity;
    const Vec3 angular = run.angular_momentum();
    run.step();
    Vec3 turned = Vec3::Zero();
    for (std::size_t i = 0; i < old.size(); ++i)
      turned += run.h() * run.world().properties[i].mass * run.world().velocity[i].cross(old[i]);
    EXPECT_LT((run.angular_momentum() - angular - turned).norm(), 1e-10 * angular.norm()) << k;
    EXPECT_TRUE(run.last.converged) << k;
    EXPECT_LE(energy(), before) << k;
    before = energy();
  }
  EXPECT_LT(before, 0.99 * start);
  EXPECT_LT((run.momentum() - momentum).norm(), 1e-10 * momentum.norm());
}

// The forces of an independent law balance weight and load at each node that moves, and a second step moves nothing.
TEST(Newton, OneHugeStepIsTheStaticEquilibrium) {
  for (const double gravity : {-0.1, -3.0}) {
    Experiment run(
        beam("[8, 2, 2]", 1e4, gravity, "\n    loads: [{within: {min: [1, -1, -1], max: [1, 1, 1]}, force: [5, 10, 0]}]"));
    const ElasticMesh mesh = mesh_at_rest(run);
    run.step();
    EXPECT_TRUE(run.last.converged);
    EXPECT_LT(run.last.residual, 1e-12);
    EXPECT_LT(run.last.iterations, 20);
    const World& world = run.world();
    const std::vector<Vec3> force = mesh.forces(world.position), places = world.position;
    double lowest = 0, weight = 0;
    for (std::size_t i = 0; i < world.size(); ++i) weight -= world.properties[i].mass * gravity;
    for (std::size_t i = 0; i < world.size(); ++i) {
      lowest = std::min(lowest, world.position[i].z());
      const BodyProperties of = world.properties[i];
      if (of.motion != Motion::dynamic) continue;
      EXPECT_LT((force[i] + of.force + of.mass * run.scene->gravity).norm(), 1e-8 * (weight + 11)) << i;
    }
    EXPECT_LT(lowest, gravity == -3 ? -0.4 : -0.1);
    run.step();
    for (std::size_t i = 0; i < world.size(); ++i) EXPECT_LT((world.position[i] - places[i]).norm(), 1e-8) << i;
  }
}

TEST(Newton, ItsImpulsesAreThoseOfTheLaw) {
  Experiment run(beam("[4, 1, 1]", 0.016, -9.8));
  run.steps(3);
  const auto& list = std::get<ConstraintList<Tetrahedron>>(run.simulation->constraints);
  const auto& impulses = std::get<MultiplierList<Tetrahedron>>(run.simulation->constraint_multipliers);
  ASSERT_EQ(impulses.size(), list.size());
  for (std::size_t i = 0; i < list.size(); ++i) {
    std::array<Vec4d, 10> parameters;
    std::array<Vec3x4, 4> x;
    for (std::size_t p = 0; p < 10; ++p) parameters[p] = broadcast(list[i].parameters[p]);
    for (std::size_t e = 0; e < 4; ++e) {
      const Vec3& at = run.world().position[static_cast<std::size_t>(list[i].ids[e])];
      x[e] = {broadcast(at.x()), broadcast(at.y()), broadcast(at.z())};
    }
    Rows<4, 6> rows;
    Tetrahedron::evaluate(parameters, x, rows);
    for (std::size_t k = 0; k < 6; ++k)
      EXPECT_NEAR(impulses[i][k], -0.016 * rows.value[k][0] / list[i].compliance[k], 1e-9) << i << ' ' << k;
  }
}

// Too few iterations for a huge step: said, with how far the nodes still are from where they belong.
TEST(Newton, SaysWhereItDoesNotConverge) {
  Experiment run(beam("[8, 2, 2]", 1e4, -3));
  run.simulation->detect();
  ReferenceSettings settings;
  settings.iterations = 3;
  const ReferenceStep step = reference_step(run.world(), run.simulation->constraints, run.scene->gravity, run.h(), settings);
  EXPECT_FALSE(step.converged);
  EXPECT_GT(run.h() * step.correction, 1e-3);
  EXPECT_EQ(step.reason, "DIVERGED_MAX_IT");
}

// The air's impulse is part of the prediction: the total form of an iterative solver converges to the same steps.
TEST(Newton, TheAirIsThatOfTheIterativeSolvers) {
  std::vector<Vec3> places;
  for (const bool newton : {true, false}) {
    Scene scene = scene_from_text(
        "wind: [0, 3, 1]\ncloths:\n  - grid: {size: [1, 1], nodes: [6, 6]}\n    mass: 0.5\n    thickness: 0.01\n    drag: 1\n    "
        "links: {stiffness: 500, damping: 0.01}\n    pins: [{node: [0, 0]}, {node: [5, 0]}]\n");
    scene.solver.tolerance = 0, scene.time.step = 0.004;
    if (newton)
      scene.solver.name = "newton";
    else
      scene.solver.form = Form::total, scene.solver.iterations = 3000;
    Experiment run(std::move(scene));
    run.steps(10);
    if (newton) {
      EXPECT_TRUE(run.last.converged);
      places = run.world().position;
    } else {
      for (std::size_t i = 0; i < places.size(); ++i) EXPECT_LT((run.world().position[i] - places[i]).norm(), 1e-9) << i;
    }
  }
}

}  // namespace unibody::small_worlds
