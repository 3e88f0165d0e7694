// The stages of a step: what each of them stops, and what is measured of it.
#include "step/stages.hpp"

#include <gtest/gtest.h>

#include "small_worlds.hpp"
#include "step/assemble.hpp"

namespace unibody::small_worlds::stages_test {

class StagesOf : public testing::TestWithParam<const char*> {
 protected:
  // A ball that comes down at 2 m/s and overlaps the ground by 1 mm.
  StagesOf()
      : run(scene_from_text("solver: {name: " + std::string(GetParam()) +
                            "}\nmaterials: {m: {friction: 0}}\nbodies:\n  - {shape: {plane: {normal: [0, 0, 1]}}}\n  - {shape: "
                            "{sphere: {radius: 0.1}}, mass: 3, position: [0, 0, 0.099], velocity: [0.5, 0, -2]}\n")),
        system(&run.simulation->scratch) {
    run.simulation->detect();
    predict(*run.simulation, system);
    assemble(*run.simulation, system, {});
    facts = facts_of(*run.simulation, system);
    plan = unibody::plan(run.scene->solver, run.simulation->traits, facts);
    warm_start(*run.simulation, system, plan);
  }
  SolveReport take(Stage::Kind kind, int iterations) {
    return run_stage(*run.simulation, system, plan, facts, kind, run.simulation->solver.solve, iterations, 0);
  }
  Vec3 velocity() const { return Eigen::Map<const Vec3>(system.bodies[run.slot(1)].v); }
  StepReport measured(double left = 0) {
    StepReport report;
    measure_solution(*run.simulation, system, plan, report, left);
    return report;
  }

  Experiment run;
  System system;
  StepFacts facts;
  StepPlan plan;
};

// The velocity stage stops it and leaves the overlap alone; the position stage takes it out at the speed of recovery.
TEST_P(StagesOf, VelocitiesFirstThenPositions) {
  ASSERT_TRUE(plan.two_stages);
  take(Stage::Kind::velocity, 200);
  EXPECT_NEAR(velocity().z(), 0, 1e-12);
  EXPECT_NEAR(velocity().x(), 0.5, 1e-15);
  EXPECT_NEAR(system.contacts().total_impulses()[0].n, 3 * (2 + 9.81 * 0.016), 1e-9);
}

// h (v_n + overlap / h) of a contact that nothing has been done for; nothing of one that is solved; and what an earlier stage
// left.
TEST_P(StagesOf, TheResidualIsWhatIsLeft) {
  take(Stage::Kind::velocity, 200);
  EXPECT_LT(measured().residual, 1e-12);
  EXPECT_TRUE(measured().converged);
  EXPECT_DOUBLE_EQ(measured(0.5).residual, 0.5);
  EXPECT_FALSE(measured(0.5).converged);
  Eigen::Map<Vec3>(system.bodies[run.slot(1)].v).z() = -0.25;
  EXPECT_NEAR(measured().residual, 0.25 * 0.016, 1e-12);
}

// From the multipliers of the last step, in full, the velocity stage has nothing left to do at rest.
TEST_P(StagesOf, AStepAtRestStartsWhereTheLastEnded) {
  run.steps(60);
  run.simulation->detect();
  System next(&run.simulation->scratch);
  predict(*run.simulation, next);
  assemble(*run.simulation, next, {});
  warm_start(*run.simulation, next, plan);
  EXPECT_NEAR(next.bodies[run.slot(1)].v[2], 0, 1e-6);
}

INSTANTIATE_TEST_SUITE_P(Solvers, StagesOf, testing::Values("accelerated_jacobi", "gauss_seidel"));

}  // namespace unibody::small_worlds::stages_test
