// Gaps evaluated in every iteration: where the bodies are at the end of the step, not along the normal of its start.
#include <gtest/gtest.h>

#include <cmath>

#include "small_worlds.hpp"

namespace unibody::small_worlds::reevaluated_gap_test {

namespace {

Scene one_step_scene(const std::string& solver, Gap gap, Stages stages) {
  Scene scene = scene_with(0);
  scene.gravity = Vec3::Zero();
  scene.solver.name = solver, scene.solver.gap = gap, scene.solver.stages = stages;
  scene.solver.iterations = 400, scene.solver.tolerance = 0;
  return scene;
}

}  // namespace

// A ball passes over another one, touching it. The frozen gap is that to the plane between them at the start of the step: along
// it the ball leaves the other one. Evaluated anew, they touch at the end.
TEST(ReevaluatedGap, BallsTouchAtTheEndOfTheStep) {
  const double h = 0.016;
  for (const std::string solver : {"accelerated_jacobi", "jacobi", "gauss_seidel"})
    for (const auto stages : {Stages::position, Stages::together})
      for (const auto gap : {Gap::frozen, Gap::reevaluated}) {
        Scene scene = one_step_scene(solver, gap, stages);
        scene.solver.margin = 0.1;
        Body upper = ball(1, 0.5, Vec3(0, 0, 1)), lower = ball(3, 0.5, Vec3::Zero());
        upper.state.velocity = Vec3(6, 0, -3), lower.state.velocity = Vec3(0, 1, 0);
        add(scene, upper), add(scene, lower);
        Experiment run(scene);
        const Vec3 momentum = run.momentum();
        run.step();
        const double apart = (run.position(0) - run.position(1)).norm();
        const double frozen = std::sqrt(1 + h * h * (6 * 6 + 1 * 1));  // free motion along the plane, none across it
        EXPECT_NEAR(apart, gap == Gap::frozen ? frozen : 1, 1e-9) << solver;
        EXPECT_LT((run.momentum() - momentum).norm(), 1e-12);
        EXPECT_LT(run.last.residual, 1e-9) << solver;
      }
}

// A spinning cube comes down on one corner, which is fixed to it: at the end of the step just that corner is on the ground.
TEST(ReevaluatedGap, ASpinningCubeTouchesWithItsCorner) {
  for (const std::string solver : {"accelerated_jacobi", "jacobi", "gauss_seidel"})
    for (const auto gap : {Gap::frozen, Gap::reevaluated}) {
      Scene scene = one_step_scene(solver, gap, Stages::position);
      const Quat turn(Eigen::AngleAxisd(0.5, Vec3(1, 2, 0).normalized()));
      const Vec3 edges(0.4, 0.4, 0.4);
      Vec3 corner = Vec3::Zero();  // the lowest one, in body axes
      for (int k = 0; k < 8; ++k) {
        const Vec3 other = 0.5 * edges.cwiseProduct(Vec3(k & 1 ? 1 : -1, k & 2 ? 1 : -1, k & 4 ? 1 : -1));
        if ((turn * other).z() < (turn * corner).z()) corner = other;
      }
      Body box = block(2, edges, Vec3(0, 0, -(turn * corner).z()), turn);
      box.state.velocity = Vec3(1, 0, -2), box.state.angular_velocity = Vec3(3, 8, 2);
      add(scene, box);
      add(scene, ground());
      Experiment run(scene);
      run.step();
      const auto height = [&](const BodyState& s) { return (s.position + s.orientation * corner).z(); };
      const BodyState end = run.state(0);
      if (gap == Gap::reevaluated) {
        EXPECT_NEAR(height(end), 0, 1e-9) << solver;
      } else {  // what is left over by the straight path of the corner
        const double straight = (turn * corner + run.h() * (end.velocity + end.angular_velocity.cross(turn * corner))).z();
        EXPECT_NEAR(straight, (turn * corner).z(), 1e-9) << solver;
        EXPECT_GT(std::abs(height(end)), 1e-4) << solver;
      }
    }
}

}  // namespace unibody::small_worlds::reevaluated_gap_test
