// The error that a step tells of itself, against steps that converge, from the same state.
#include "step/step_error.hpp"

#include <gtest/gtest.h>

#include "report/state_hash.hpp"
#include "small_worlds.hpp"

namespace unibody::small_worlds::step_error_test {

namespace {

std::string with_solver(const std::string& bodies, const std::string& solver) { return bodies + "\nsolver: {" + solver + "}\n"; }

// Cubes, which keep their spin within a step, without friction, whose steps have one solution.
const std::string cubes = R"(
materials: {ice: {friction: 0}}
bodies:
  - {shape: {plane: {normal: [0, 0, 1]}}, material: ice}
  - pile:
      count: 24
      columns: [2, 2]
      seed: 3
      mix: [{shape: {box: {size: [0.2, 0.2, 0.2]}}}]
    density: 1000
    velocity: [0, 0, -3]
    material: ice)";

// A bridge of three boxes, of which a fourth lands: a few hundred iterations converge.
const std::string few = R"(
bodies:
  - {shape: {plane: {normal: [0, 0, 1]}}}
  - {shape: {box: {size: [0.2, 0.2, 0.2]}}, mass: 1, position: [-0.2, 0, 0.1]}
  - {shape: {box: {size: [0.2, 0.2, 0.2]}}, mass: 1, position: [0.2, 0, 0.1]}
  - {shape: {box: {size: [0.6, 0.2, 0.1]}}, mass: 1, position: [0, 0, 0.25]}
  - {shape: {sphere: {radius: 0.1}}, mass: 1, position: [0.05, 0, 0.42], velocity: [0.5, 0.2, -2]})";

const std::string rope = R"(
threads:
  - {name: rope, points: [[0, 0, 0], [1, 0, 0]], segments: 12, mass: 0.3, radius: 0.005, pins: [{node: 0}]})";

const std::string boxes_and_cloth = R"(
bodies:
  - {shape: {plane: {normal: [0, 0, 1]}}}
  - {shape: {box: {size: [0.3, 0.2, 0.1]}}, mass: 1, position: [0.4, 0.4, 0.4], velocity: [0, 0, -3]}
  - {shape: {box: {size: [0.3, 0.2, 0.1]}}, mass: 1, position: [0.4, 0.45, 0.55], velocity: [0.5, 0, -3]}
cloths:
  - name: sheet
    grid: {size: [1, 1], nodes: [9, 9]}
    mass: 0.4
    thickness: 0.02
    links: {}
    position: [0.4, 0.4, 0.25]
    pins: [{node: [0, 0]}, {node: [8, 0]}, {node: [0, 8]}, {node: [8, 8]}])";

const std::string solid = R"(
bodies:
  - {shape: {plane: {normal: [0, 0, 1]}}}
  - {shape: {sphere: {radius: 0.1}}, mass: 2, position: [0.2, 0.2, 0.62], velocity: [0, 0, -2]}
solids:
  - {name: block, block: {size: [0.4, 0.4, 0.4], cells: [2, 2, 2]}, density: 500, youngs_modulus: 1.0e+5, poissons_ratio: 0.3, thickness: 0.01, position: [0.2, 0.2, 0.25]})";

// Of local solvers each iteration tells a link of its neighbours alone: they need thousands.
const std::string chain = R"(
bodies:
  - shape: {box: {size: [0.09, 0.03, 0.03]}}
    mass: 0.1
    position: [0, 0, 4]
    chain: {count: 30, from: [0, 0, 0], to: [1.5, 0, -2.6], held: start, joint: {type: ball}, ball: {radius: 0.2, mass: 20}})";

// Two chains between a ball and the world: of their joints one closes a loop; the ball lies on the ground.
const std::string loop = R"(
bodies:
  - {shape: {plane: {normal: [0, 0, 1]}}}
  - {name: ball, shape: {sphere: {radius: 0.1}}, mass: 20, position: [0, 0, 0.1]}
  - {name: left, shape: {box: {size: [0.1, 0.05, 0.05]}}, mass: 1, position: [-0.25, 0, 0.3]}
  - {name: right, shape: {box: {size: [0.1, 0.05, 0.05]}}, mass: 1, position: [0.25, 0, 0.3]}
joints:
  - {type: ball, bodies: [left, ball], anchor: [-0.1, 0, 0.2]}
  - {type: ball, bodies: [right, ball], anchor: [0.1, 0, 0.2]}
  - {type: ball, bodies: [left, world], anchor: [-0.4, 0, 0.4]}
  - {type: ball, bodies: [right, world], anchor: [0.4, 0, 0.4]})";

Experiment from(Experiment& start, const std::string& text) {
  Experiment e(scene_from_text(text));
  Simulation &to = *e.simulation, &of = *start.simulation;
  to.world = of.world, to.when.steps_done = of.when.steps_done;
  to.make_constraints();
  to.history = of.history;
  return e;
}

StepError error_of_next_step(Experiment& e) { return e.simulation->step({.error = true}).error.value(); }

// m, of the states that the two steps ended with.
double distance(const World& one, const World& other, double h) {
  double sum = 0, mass = 0;
  for (std::size_t i = 0; i < one.homes; ++i) {
    const BodyProperties& body = one.properties[i];
    if (!body.is_dynamic()) continue;
    const double turning = one.has_rotations && body.shape.kind != ShapeKind::particle
                               ? body.inertia.x() * (one.angular_velocity[i] - other.angular_velocity[i]).squaredNorm()
                               : 0;
    sum += body.mass * (one.velocity[i] - other.velocity[i]).squaredNorm() + turning, mass += body.mass;
  }
  return h * std::sqrt(sum / mass);
}

}  // namespace

TEST(StepError, FallsWithIterations) {
  Experiment start(scene_from_text(with_solver(cubes, "iterations: 30")));
  start.steps(15);
  for (const std::string solver : {"accelerated_jacobi", "gauss_seidel", "jacobi"}) {
    double last = HUGE_VAL, first = 0;
    for (const int iterations : {4, 16, 64, 256}) {
      Experiment e = from(
          start,
          with_solver(cubes, "name: " + solver + ", tolerance: 0, stages: together, iterations: " + std::to_string(iterations)));
      const StepError error = error_of_next_step(e);
      EXPECT_LT(error.distance, last) << solver << ", iterations: " << iterations;
      EXPECT_LT(error.reference_residual, 1e-5) << solver;
      if (iterations == 4) first = error.distance;
      last = error.distance;
    }
    EXPECT_GT(first, 1e-4) << solver << ": nothing is pressed together, such a step tells nothing";
    EXPECT_LT(last, solver == "jacobi" ? first / 2 : first / 10) << solver;
  }
}

TEST(StepError, IsTheDistanceToAnotherRunThatConverges) {
  Experiment start(scene_from_text(with_solver(cubes, "iterations: 35")));
  start.steps(15);
  Experiment converged =
      from(start, with_solver(cubes, "name: accelerated_jacobi, tolerance: 0, stages: together, iterations: 400000"));
  converged.step();
  ASSERT_LT(converged.last.residual, 1e-9);
  for (const std::string solver : {"name: accelerated_jacobi", "name: gauss_seidel", "name: gauss_seidel, stages: together",
                                   "name: accelerated_jacobi, stages: position"}) {
    Experiment e = from(start, with_solver(cubes, solver + ", iterations: 12"));
    const StepError error = error_of_next_step(e);
    const double found = distance(e.world(), converged.world(), e.h());
    EXPECT_GT(found, 1e-4) << solver;
    EXPECT_LT(error.reference_residual, 1e-4 * found) << solver;
    EXPECT_NEAR(error.distance, found, 1e-6 * found) << solver;
    EXPECT_GT(error.relative, 0) << solver;
  }
}

// Of a chain, with either local solver: the distance to the step that iterations of another kind lead to, joint by joint.
TEST(StepError, OfAChainIsTheDistanceToItsConvergedStep) {
  Experiment start(scene_from_text(with_solver(chain, "joints: direct, iterations: 20")));
  start.steps(20);
  Experiment converged = from(start, with_solver(chain, "name: accelerated_jacobi, tolerance: 0, iterations: 60000"));
  converged.step();
  ASSERT_LT(converged.last.residual, 1e-10);
  for (const std::string solver : {"name: gauss_seidel", "name: accelerated_jacobi", "name: jacobi"}) {
    Experiment e = from(start, with_solver(chain, solver + ", iterations: 10"));
    const StepError error = error_of_next_step(e);
    const double found = distance(e.world(), converged.world(), e.h());
    EXPECT_GT(found, 1e-4) << solver;
    EXPECT_LT(error.reference_residual, 1e-10) << solver;
    EXPECT_NEAR(error.distance, found, 1e-5 * found) << solver;
  }
}

// Of the velocity level: the distance to its own converged step, which is another one. The cubes are taken at a time at which
// friction leaves one converged step only.
TEST(StepError, IsOfTheLevelThatTheStepHas) {
  Experiment start(scene_from_text(with_solver(cubes, "iterations: 30, velocity_share: 0.5, leak: 0")));
  start.steps(16);
  const std::string exactly = "name: accelerated_jacobi, tolerance: 0, iterations: 400000, ";
  Experiment converged = from(start, with_solver(cubes, exactly + "level: velocity"));
  Experiment of_positions = from(start, with_solver(cubes, exactly + "stages: together"));
  converged.step(), of_positions.step();
  ASSERT_LT(converged.last.residual, 1e-11);
  EXPECT_GT(distance(of_positions.world(), converged.world(), converged.h()), 1e-4);
  for (const std::string solver : {"accelerated_jacobi", "gauss_seidel"}) {
    Experiment e = from(start, with_solver(cubes, "level: velocity, iterations: 12, name: " + solver));
    const StepError error = error_of_next_step(e);
    const double found = distance(e.world(), converged.world(), e.h());
    EXPECT_GT(found, 1e-4) << solver;
    EXPECT_LT(error.reference_residual, 1e-4 * found) << solver;
    EXPECT_NEAR(error.distance, found, 1e-6 * found) << solver;
  }
}

// A rope: the total form converges to implicit Euler, of which Newton's method has the step to round-off.
TEST(StepError, IsTheDistanceToNewtonsStep) {
  Experiment start(scene_from_text(with_solver(rope, "name: gauss_seidel, form: total, iterations: 40")));
  start.steps(10);
  Experiment converged = from(start, with_solver(rope, "name: newton"));
  converged.step();
  ASSERT_TRUE(converged.last.converged);
  Experiment e = from(start, with_solver(rope, "name: gauss_seidel, form: total, iterations: 6"));
  const StepError error = error_of_next_step(e);
  const double found = distance(e.world(), converged.world(), e.h());
  EXPECT_GT(found, 1e-5);
  EXPECT_NEAR(error.distance, found, 1e-6 * found);
}

TEST(StepError, LeavesTheRunAsItIs) {
  for (const std::string& bodies : {cubes, boxes_and_cloth, solid, chain, loop})
    for (const std::string solver :
         {"name: accelerated_jacobi, iterations: 12", "name: gauss_seidel, iterations: 8", "name: jacobi, iterations: 12",
          "name: gauss_seidel, iterations: 8, form: total", "name: accelerated_jacobi, iterations: 12, friction: postprocess",
          "name: accelerated_jacobi, iterations: 12, stages: together, gap: reevaluated"}) {
      Experiment plain(scene_from_text(with_solver(bodies, solver))), asked(scene_from_text(with_solver(bodies, solver)));
      double largest = 0;
      for (int step = 0; step < 9; ++step) {
        plain.step();
        if (step % 4 == 0)
          largest = std::max(largest, error_of_next_step(asked).distance);
        else
          asked.step();
      }
      EXPECT_EQ(state_hash(MPI_COMM_SELF, asked.world()), state_hash(MPI_COMM_SELF, plain.world())) << bodies << solver;
      EXPECT_GT(largest, 1e-8) << "each step converged by itself: nothing was solved on";
    }
}

TEST(RanksStepError, IsTheSameOnAnyNumberOfRanks) {
  const std::string jacobi = "name: accelerated_jacobi, iterations: 12, tolerance: 0.01";
  const std::string gauss_seidel = "name: gauss_seidel, iterations: 8, tolerance: 0.01";
  for (const auto& [bodies, solver] : std::vector<std::pair<std::string, std::string>>{
           {few, jacobi}, {few, gauss_seidel}, {solid, jacobi}, {chain, gauss_seidel}, {loop, jacobi}}) {
    Experiment alone(scene_from_text(with_solver(bodies, solver)));
    Experiment together(scene_from_text(with_solver(bodies, solver)), MPI_COMM_WORLD);
    alone.steps(5), together.steps(5);
    const StepError one = error_of_next_step(alone), other = error_of_next_step(together);
    EXPECT_GT(one.distance, 0);
    EXPECT_EQ(one.distance, other.distance) << bodies << solver;
    EXPECT_EQ(one.relative, other.relative);
    EXPECT_EQ(one.reference_residual, other.reference_residual);
    EXPECT_EQ(one.iterations, other.iterations);
  }
}

}  // namespace unibody::small_worlds::step_error_test
