// Tests of what assembling a step gives: the predicted velocities, the number of constraints that share each body, and the places
// to which bodies are moved at the end.
#include "step/assemble.hpp"

#include <gtest/gtest.h>

#include "small_worlds.hpp"

namespace unibody::small_worlds::assemble_test {

namespace {

const std::string stack =
    "materials: {m: {friction: 0.5}}\nbodies:\n  - {shape: {plane: {normal: [0, 0, 1]}}}\n  - {shape: {sphere: {radius: 0.1}}, "
    "mass: 2, position: [0, 0, 0.1]}\n  - {shape: {sphere: {radius: 0.1}}, mass: 3, position: [0, 0, 0.3], force: [6, 0, 0], "
    "velocity: [0, 1, 0]}\n  - {shape: {box: {size: [1, 1, 1]}}, mass: 1, position: [9, 0, 9], velocity: [0, 0, 2], "
    "angular_velocity: [0, 0, 3]}\n";

struct Assembled {
  explicit Assembled(const std::string& text) : run(scene_from_text(text)), system(&run.simulation->scratch) {
    run.simulation->detect();
    predict(*run.simulation, system);
    assemble(*run.simulation, system, {});
  }
  Vec3 velocity(Id id) const { return Eigen::Map<const Vec3>(system.bodies[run.slot(id)].v); }

  Experiment run;
  System system;
};

}  // namespace

// A free body is predicted to move at v + h (g + F / m), and a fixed body not at all.
TEST(Assemble, PredictsFreeMotion) {
  const Assembled found(stack);
  const double h = 0.016;
  EXPECT_LT((found.velocity(1) - h * Vec3(0, 0, -9.81)).norm(), 1e-15);
  EXPECT_LT((found.velocity(2) - Vec3(2 * h, 1, -9.81 * h)).norm(), 1e-15);
  EXPECT_EQ(found.system.bodies[found.run.slot(2)].inverse_mass, 1.0 / 3);
  const SolverBody& plane = found.system.bodies[found.run.slot(0)];
  EXPECT_EQ(plane.inverse_mass, 0);
  EXPECT_EQ(Eigen::Map<const Vec3>(plane.v), Vec3::Zero());
}

// For the Jacobi solvers: the lower ball is in two contacts, the upper one in one, the box in none. Gauss-Seidel shares nothing.
TEST(Assemble, CountsTheConstraintsOfEachBody) {
  const Assembled found(stack);
  EXPECT_EQ(found.system.counts[found.run.slot(1)], 2);
  EXPECT_EQ(found.system.counts[found.run.slot(2)], 1);
  EXPECT_EQ(found.system.counts[found.run.slot(3)], 0);
  EXPECT_TRUE(Assembled("solver: {name: gauss_seidel}\n" + stack).system.counts.empty());
}

TEST(Assemble, FactsAreThoseOfTheStep) {
  Assembled touching(stack);
  EXPECT_TRUE(facts_of(*touching.run.simulation, touching.system).any_contact);
  EXPECT_FALSE(facts_of(*touching.run.simulation, touching.system).bounces);
  Assembled apart("bodies:\n  - {shape: {sphere: {radius: 0.1}}, mass: 1}\n");
  EXPECT_FALSE(facts_of(*apart.run.simulation, apart.system).any_contact);
}

// Where no solve has changed the velocities, every body moves on as it was predicted to, even into another body.
TEST(Assemble, FinaliseMovesByTheVelocities) {
  Assembled found(stack);
  const double h = 0.016;
  finalise(*found.run.simulation, found.system);
  EXPECT_LT((found.run.position(2) - Vec3(2 * h * h, h, 0.3 - 9.81 * h * h)).norm(), 1e-15);
  EXPECT_LT((found.run.velocity(2) - Vec3(2 * h, 1, -9.81 * h)).norm(), 1e-15);
  EXPECT_LT((found.run.state(3).angular_velocity - Vec3(0, 0, 3)).norm(), 1e-12);
  EXPECT_EQ(found.run.position(0), Vec3::Zero());
}

}  // namespace unibody::small_worlds::assemble_test
