// Limits of ball joints: a cone for the axis, a range for the twist about it.
#include <gtest/gtest.h>

#include <cmath>

#include "small_worlds.hpp"

namespace unibody::small_worlds::ball_limits_test {

namespace {

const char* const solver_list[] = {"accelerated_jacobi", "jacobi", "gauss_seidel"};

// A rod of 1 m and 1 kg below a ball joint, whose axis points down.
std::string rod(const std::string& solver, const std::string& gravity, const std::string& torque, const std::string& limits) {
  return "gravity: " + gravity +
         "\nbodies:\n  - {name: rod, shape: {box: {size: [0.1, 0.1, 1]}}, mass: 1, position: [0, 0, -0.5], torque: " + torque +
         "}\njoints:\n  - {type: ball, bodies: [rod, world], anchor: [0, 0, 0], axis: [0, 0, -1], " + limits +
         "}\nsolver: {iterations: 300, tolerance: 0, name: " + solver + "}\ntime: {frame: 0.01}\n";
}

double swing_of(const Experiment& run) { return run.simulation->joint_states()[0].coordinate; }

}  // namespace

// Pulled to a side it leans on the cone, which bears the torque that is left: m g d cos a.
TEST(BallLimits, AConeHolds) {
  for (const char* solver : solver_list)
    for (const char* gravity : {"[9.81, 0, 0]", "[5.886, -7.848, 0]"}) {
      Experiment run(scene_from_text(rod(solver, gravity, "[0, 0, 0]", "swing_limit: 30")));
      double most = 0;
      for (int k = 0; k < 200; ++k) run.step(), most = std::max(most, swing_of(run));
      EXPECT_LT(most, M_PI / 6 + 1e-6) << solver;
      EXPECT_NEAR(swing_of(run), M_PI / 6, 1e-6) << solver;
      EXPECT_NEAR(run.simulation->joint_states()[0].limit, 9.81 * 0.5 * std::cos(M_PI / 6), 1e-3) << solver;
      const Vec3 way = run.scene->gravity.normalized() * std::sin(M_PI / 6) * 0.5;
      EXPECT_LT((run.position(0) - way + Vec3(0, 0, 0.5 * std::cos(M_PI / 6))).norm(), 1e-4) << solver;
    }
}

// Turned about its axis it comes to the end of its range, in either sense, and swings freely meanwhile.
TEST(BallLimits, ATwistEndsWhereItMay) {
  for (const char* solver : solver_list)
    for (const bool forwards : {false, true}) {
      Experiment run(
          scene_from_text(rod(solver, "[0, 0, -9.81]", forwards ? "[0, 0, -0.02]" : "[0, 0, 0.02]", "twist_limits: [-20, 45]")));
      run.world().velocity[0] = Vec3(0.1, 0, 0), run.world().angular_velocity[0] = Vec3(0, -0.2, 0);
      const double end = (forwards ? 45 : -20) * M_PI / 180;
      double most = 0, swing = 0;
      for (int k = 0; k < 200; ++k) {
        run.step();
        const Quat q = run.state(0).orientation;
        most = std::max(most, std::abs(2 * std::atan2(q.z(), q.w()))), swing = std::max(swing, swing_of(run));
      }
      EXPECT_NEAR(most, std::abs(end), 1e-5) << solver;
      EXPECT_NEAR(run.simulation->joint_states()[0].limit, 0.02, 1e-3) << solver;
      EXPECT_GT(swing, 0.03) << solver;
    }
}

// Figures stand within the limits of their joints.
TEST(BallLimits, AFigureStandsWithinItsLimits) {
  Experiment run(scene_from_text("bodies:\n  - {ragdolls: {count: 3, columns: [3, 1], spacing: [3, 3, 3]}, density: 900}\n"));
  run.simulation->detect();
  int limited = 0;
  for (const Joint& joint : run.scene->joints) limited += joint.is_limited();
  EXPECT_EQ(limited, 30) << "every joint of a figure has its limits";
  for (const JointState& s : run.simulation->joint_states()) EXPECT_LT(s.turn, 1e-12);
}

}  // namespace unibody::small_worlds::ball_limits_test
