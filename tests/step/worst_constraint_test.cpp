// The constraint that a step names as the farthest from solved is the one whose residual the step has.
#include "step/worst_constraint.hpp"

#include <gtest/gtest.h>

#include "partition/balance.hpp"
#include "small_worlds.hpp"
#include "step/step_parts.hpp"

namespace unibody::small_worlds::worst_constraint_test {
namespace {

// Rolling spheres, boxes, a chain with a motor, a cloth that is held by a body and touched by others: far from converged.
std::string all_kinds(const std::string& solver) {
  return "time: {frame: 0.02}\nsolver: " + solver +
         "\nmaterials: {a: {friction: 0.5, rolling_friction: 0.01}}\n"
         "bodies:\n"
         "  - {name: ground, shape: {plane: {normal: [0, 0, 1]}}}\n"
         "  - {name: pile, pile: {count: 40, columns: [3, 3], mix: [{shape: {sphere: {radius: 0.05}}}, {shape: {box: {size: "
         "[0.1, "
         "0.08, 0.06]}}}]}, density: 2000, position: [0, 0, 0.7], velocity: [0, 0, -2]}\n"
         "  - {name: arm, shape: {box: {size: [0.1, 0.1, 0.3]}}, mass: 1, position: [2, 0, 1]}\n"
         "  - {name: weight, shape: {sphere: {radius: 0.1}}, mass: 30, position: [2, 0, 0.6]}\n"
         "cloths:\n"
         "  - {grid: {size: [1, 1], nodes: [12, 12]}, mass: 0.3, thickness: 0.02, self_collision: true, position: [0, 0, 0.5],\n"
         "     pins: [{node: [0, 0]}, {node: [11, 11]}, {node: [0, 11], to: weight}]}\n"
         "joints:\n"
         "  - {type: ball, bodies: [arm, world], anchor: [2, 0, 1.2]}\n"
         "  - {type: hinge, bodies: [arm, weight], anchor: [2, 0, 0.8], axis: [0, 1, 0], motor: {speed: 3, max_torque: 20}}\n";
}

StepRequest that_names() {
  StepRequest request;
  request.name_above = 0;
  return request;
}

class WorstConstraintOfAStep : public testing::TestWithParam<const char*> {};

TEST_P(WorstConstraintOfAStep, WithTheResidualOfTheStep) {
  Experiment run(scene_from_text(all_kinds(GetParam())));
  for (int k = 0; k < 60; ++k) {
    const StepReport report = run.simulation->step(that_names());
    ASSERT_TRUE(report.worst.has_value()) << k;
    EXPECT_EQ(report.worst->residual, report.residual) << k;
    EXPECT_FALSE(report.worst->kind.empty());
    EXPECT_NE(report.worst->bodies[0], WorstConstraint::none);
    EXPECT_FALSE(run.simulation->step().worst.has_value());  // nobody asked
  }
}

TEST_P(WorstConstraintOfAStep, ChangesNoBits) {
  Experiment run(scene_from_text(all_kinds(GetParam()))), other(scene_from_text(all_kinds(GetParam())));
  for (int k = 0; k < 30; ++k) run.simulation->step(that_names()), other.step();
  for (std::size_t i = 0; i < run.world().size(); ++i) ASSERT_EQ(run.world().position[i], other.world().position[i]);
}

INSTANTIATE_TEST_SUITE_P(Solvers, WorstConstraintOfAStep,
                         testing::Values("{name: accelerated_jacobi, iterations: 6}",
                                         "{name: jacobi, iterations: 6, stages: two}", "{name: gauss_seidel, iterations: 4}",
                                         "{name: accelerated_jacobi, iterations: 6, stages: "
                                         "together}"));

// Nothing else is far from solved: a stack at rest, and a chain of light links with a ball a thousand times as heavy.
TEST(WorstConstraint, IsALinkOfTheLoadedChain) {
  Experiment run(
      scene_from_text("bodies:\n"
                      "  - {name: ground, shape: {plane: {normal: [0, 0, 1]}}}\n"
                      "  - {name: crate, shape: {box: {size: [1, 1, 1]}}, mass: 1, position: [5, 0, 0.5]}\n"
                      "  - shape: {box: {size: [0.09, 0.03, 0.02]}}\n    name: link\n    mass: 0.1\n"
                      "    chain: {count: 20, from: [0, 0, 5], to: [1.8, 0, 5], held: start, joint: {type: ball}, ball: {radius: "
                      "0.1, mass: 100}}\n"));
  for (int k = 0; k < 20; ++k) run.step();
  const StepReport report = run.simulation->step(that_names());
  EXPECT_EQ(report.worst->kind, "joints");
  EXPECT_GE(report.worst->bodies[0], 2);
  EXPECT_GT(report.residual, 1e-5);
}

// The same name on any number of ranks: every rank runs the scene alone as well.
TEST(RanksWorstConstraint, HasTheSameName) {
  for (const std::string solver : {"{name: accelerated_jacobi, iterations: 6}", "{name: gauss_seidel, iterations: 4}"}) {
    Experiment alone(scene_from_text(all_kinds(solver))), run(scene_from_text(all_kinds(solver)), MPI_COMM_WORLD);
    const Balance balance(MPI_COMM_WORLD, 5, true);
    run.simulation->move_homes(balance.homes(parts_of(*run.simulation)));
    for (int k = 0; k < 30; ++k) {
      const StepReport a = alone.simulation->step(that_names()), b = run.simulation->step(that_names());
      ASSERT_EQ(a.worst->residual, b.worst->residual) << solver << k;
      ASSERT_EQ(a.worst->kind, b.worst->kind) << solver << k;
      ASSERT_EQ(a.worst->bodies, b.worst->bodies) << solver << k;
    }
  }
}

// Four balls that fall alike: of equal residuals the one of the first bodies is named, on any ranks.
TEST(RanksWorstConstraint, OfEqualsIsTheFirst) {
  std::string text = "time: {frame: 0.1}\nsolver: {iterations: 2}\nbodies:\n  - {shape: {plane: {normal: [0, 0, 1]}}}\n";
  for (const char* x : {"3", "0", "9", "6"})
    text += std::string("  - {shape: {sphere: {radius: 0.1}}, mass: 1, position: [") + x +
            ", 0, 0.1]}\n  - {shape: {sphere: "
            "{radius: 0.1}}, mass: 1, position: [" +
            x + ", 0, 0.3]}\n";
  Experiment run(scene_from_text(text), MPI_COMM_WORLD);
  const Balance balance(MPI_COMM_WORLD, 1, true);
  run.simulation->move_homes(balance.homes(parts_of(*run.simulation)));
  const StepReport report = run.simulation->step(that_names());
  ASSERT_TRUE(report.worst.has_value());
  EXPECT_LE(report.worst->bodies[1], 2);
}

}  // namespace
}  // namespace unibody::small_worlds::worst_constraint_test
