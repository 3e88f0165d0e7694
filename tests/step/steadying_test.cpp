// Light bodies between strong joints: how fast their joints would turn them, and the inertia that they are given for it.
#include "step/steadying.hpp"

#include <gtest/gtest.h>

#include "small_worlds.hpp"
#include "step/assemble.hpp"

namespace unibody::small_worlds::steadying_test {

namespace {

// A ball of 2 kg that hangs at rest, 0.5 m below its joint with the world.
const std::string bob =
    "solver: {joints: direct, iterations: 20}\nbodies:\n  - {name: bob, shape: {sphere: {radius: 0.1}}, mass: 2, position: [0, "
    "0, "
    "-0.5]}\njoints:\n  - {type: ball, bodies: [bob, world], anchor: [0, 0, 0]}\n";

}  // namespace

// h^2 K = h^2 m g a: the joint's force is the weight, and its arm is a.
TEST(Steadying, TurningIsTheForceTimesItsArm) {
  Experiment run(scene_from_text(bob));
  run.step();
  const double h = 0.016;
  run.simulation->detect();
  EXPECT_NEAR(geometric_stiffness_of_joints(*run.simulation)[run.slot(0)], h * h * 2 * 9.81 * 0.5, 1e-9);
}

// What turns slower than that keeps its inertia; another one has h^2 K instead.
TEST(Steadying, RaisesTheInertiaToWhatIsMissing) {
  Experiment run(scene_from_text(bob));
  run.simulation->detect();
  const double moment = 0.4 * 2 * 0.1 * 0.1;
  for (const double share : {0.5, 10.0}) {
    System system(&run.simulation->scratch);
    predict(*run.simulation, system);
    std::vector<double> geometric_stiffness(run.world().size() + 1, share * moment);
    steady_by_stiffness(*run.simulation, system, geometric_stiffness);
    EXPECT_NEAR(system.bodies[run.slot(0)].inverse_inertia * moment, share < 1 ? 1 : 1 / share, 1e-12) << share;
    EXPECT_EQ(system.bodies[run.slot(0)].inverse_mass, 0.5);
  }
}

// An attempt is made again while the forces that it finds are larger than it was steadied for, three times at most, and each
// starts from where the first did.
TEST(Steadying, TakesTheStepAgainForItsOwnForces) {
  Experiment run(scene_from_text(bob));
  run.simulation->detect();
  System system(&run.simulation->scratch);
  const double moment = 0.4 * 2 * 0.1 * 0.1, h = 0.016;
  const Vec3 start(1, 2, 3);
  run.world().velocity[run.slot(0)] = start;
  std::vector<double> geometric_stiffness(run.world().size() + 1, 0.0);
  int attempts = 0;
  take_steadily(*run.simulation, system, geometric_stiffness, [&] {
    ++attempts;
    EXPECT_EQ(run.world().velocity[run.slot(0)], start);
    run.world().velocity[run.slot(0)] = Vec3::Zero();
    run.simulation->history.joints().assign(1, {});
    run.simulation->history.joints()[0].value[0] = 5 * moment / (h * 0.5);  // h times this and the arm: 5 times the moment
  });
  EXPECT_EQ(attempts, 2);
  EXPECT_NEAR(geometric_stiffness[run.slot(0)], 5 * moment, 1e-12);
}

}  // namespace unibody::small_worlds::steadying_test
