// Events at a time: each against the closed form of what it sets going, or stops.
#include <gtest/gtest.h>

#include "changes/changing.hpp"

namespace unibody::small_worlds::events_test {

namespace {

// m, after n steps of length h from rest: the first adds g h to the speed, and then the body moves.
double fallen(int n, double h) { return 9.81 * h * h * n * (n + 1) / 2; }

class Substeps : public testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(OfAFrame, Substeps, testing::Values(1, 4));

std::string with_time(const std::string& rest, int substeps) {
  return "time: {frame: 0.01, frames: 100, substeps: " + std::to_string(substeps) + "}\n" + rest;
}

TEST_P(Substeps, ABodyThatIsHeldFallsFromItsRelease) {
  Changing run(with_time(R"(
bodies: [{name: a, shape: {box: {size: [0.1, 0.1, 0.1]}}, mass: 2, position: [0, 0, 5], start: held}]
events: [{do: release, bodies: a, when: {time: 0.2}}]
)",
                         GetParam()));
  run.frames(20);
  EXPECT_EQ(run.position(0), Vec3(0, 0, 5));
  EXPECT_EQ(run.velocity(0), Vec3::Zero());
  run.frames(30);
  EXPECT_NEAR(run.position(0).z(), 5 - fallen(30 * GetParam(), run.h()), 1e-12);
}

TEST_P(Substeps, ABodyThatIsFixedStaysWhereItIs) {
  Changing run(with_time(R"(
bodies: [{name: a, shape: {box: {size: [0.1, 0.1, 0.1]}}, mass: 2, position: [0, 0, 5], angular_velocity: [3, 2, 1]}]
events: [{do: fix, bodies: a, when: {time: 0.2}}, {do: release, bodies: a, when: {time: 0.5}}]
)",
                         GetParam()));
  run.frames(20);
  const BodyState there = run.state(0);
  EXPECT_NEAR(there.position.z(), 5 - fallen(20 * GetParam(), run.h()), 1e-12);
  run.frames(30);
  EXPECT_EQ(run.position(0), there.position);
  EXPECT_LT((run.state(0).orientation.coeffs() - there.orientation.coeffs()).norm(), 1e-15);
  run.frames(10);
  EXPECT_NEAR(run.position(0).z(), there.position.z() - fallen(10 * GetParam(), run.h()), 1e-12);
  EXPECT_EQ(run.state(0).angular_velocity, Vec3::Zero());
}

TEST_P(Substeps, WhatLiesOnAGateFallsWhenItIsRemoved) {
  Changing run(with_time(R"(
bodies:
  - {name: gate, shape: {box: {size: [1, 1, 0.1]}}, motion: fixed, position: [0, 0, -0.05]}
  - {name: a, shape: {sphere: {radius: 0.1}}, mass: 2, position: [0, 0, 0.1]}
events: [{do: remove, bodies: gate, when: {time: 0.3}}]
)",
                         GetParam()));
  run.frames(30);
  EXPECT_TRUE(run.is_there(0));
  const double z = run.position(1).z();
  EXPECT_NEAR(z, 0.1, 1e-6);
  run.frames(20);
  EXPECT_FALSE(run.is_there(0));
  EXPECT_NEAR(run.position(1).z(), z - fallen(20 * GetParam(), run.h()), 1e-9);
}

TEST_P(Substeps, ABodyThatIsAbsentComesIn) {
  Changing run(with_time(R"(
bodies:
  - {name: a, shape: {sphere: {radius: 0.1}}, mass: 2, position: [0, 0, 3], start: absent}
  - {name: shelf, shape: {box: {size: [1, 1, 0.1]}}, motion: fixed, position: [0, 0, -0.05], start: absent}
  - {name: b, shape: {sphere: {radius: 0.1}}, mass: 2, position: [5, 0, 3]}
events:
  - {do: add, bodies: [a, shelf], when: {time: 0.1}}
  - {do: remove, bodies: [a, b], when: {time: 0.4}}
  - {do: add, bodies: a, when: {time: 0.6}}
)",
                         GetParam()));
  run.frames(10);
  EXPECT_FALSE(run.is_there(0));
  EXPECT_FALSE(run.is_there(1));
  run.frames(10);
  EXPECT_NEAR(run.position(0).z(), 3 - fallen(10 * GetParam(), run.h()), 1e-12);
  EXPECT_NEAR(run.position(2).z(), 3 - fallen(20 * GetParam(), run.h()), 1e-12);
  run.frames(30);  // of frames 41 to 50 without a
  EXPECT_FALSE(run.is_there(0));
  EXPECT_TRUE(run.is_there(1));
  EXPECT_FALSE(run.is_there(2));
  run.frames(20);
  EXPECT_NEAR(run.position(0).z(), 3 - fallen(10 * GetParam(), run.h()), 1e-12) << "as it was at the start";
  EXPECT_FALSE(run.is_there(2));
}

// v(t) = v0 - mu g t, from the event on without friction.
TEST_P(Substeps, FrictionIsAnother) {
  Changing run(with_time(R"(
materials: {wood: {friction: 0.4}, ice: {friction: 0.4}}
bodies:
  - {shape: {plane: {normal: [0, 0, 1]}}, material: ice}
  - {name: a, shape: {box: {size: [0.2, 0.2, 0.1]}}, mass: 2, position: [0, 0, 0.05], velocity: [3, 0, 0], material: wood}
events: [{do: friction, between: [wood, ice], friction: [[0, 0], [0.2, 0.5]], when: {time: 0.25}}]
)",
                         GetParam()));
  run.frames(25);
  EXPECT_NEAR(run.velocity(1).x(), 3 - 0.4 * 9.81 * 0.25, 1e-4);
  run.frames(20);  // mu grows from 0 to 0.5 in 0.2 s: 0.25 in the mean
  EXPECT_NEAR(run.velocity(1).x(), 3 - 0.4 * 9.81 * 0.25 - 0.25 * 9.81 * 0.2, 1e-4);
}

TEST_P(Substeps, AMotorTurnsToAnotherSpeed) {
  Changing run(with_time(R"(
gravity: [0, 0, 0]
solver: {tolerance: 0}
bodies: [{name: a, shape: {box: {size: [0.2, 0.1, 0.1]}}, mass: 2}]
joints:
  - {name: axle, type: hinge, bodies: [a, world], anchor: [0, 0, 0], axis: [0, 0, 1], motor: {speed: 0, max_torque: 1.0e+6}}
events: [{do: motor, joints: axle, speed: {table: [[0, 2], [0.1, 4]], between: steps}, when: {time: 0.25}}]
)",
                         GetParam()));
  run.frames(25);
  EXPECT_NEAR(run.simulation->joint_states()[0].coordinate, 0, 1e-9);
  run.frames(20);
  EXPECT_NEAR(run.simulation->joint_states()[0].coordinate, 0.1 * 2 + 0.1 * 4, 1e-6);
}

// A joint between a body that is held and the world has no mass to move; one to a body that swings has one.
TEST(Events, JointsOfHeldBodiesHold) {
  for (const char* solver : {"accelerated_jacobi", "gauss_seidel"})
    for (const char* joints : {"iterative", "direct"}) {
      SCOPED_TRACE(std::string(solver) + joints);
      Changing run(std::string("time: {frame: 0.01, frames: 100}\nsolver: {name: ") + solver + ", joints: " + joints + R"(}
bodies:
  - {name: a, shape: {sphere: {radius: 0.05}}, mass: 2, position: [1, 0, 0], start: held}
  - {name: b, shape: {sphere: {radius: 0.05}}, mass: 2, position: [2, 0, 0]}
joints:
  - {type: ball, bodies: [a, world], anchor: [0, 0, 0]}
  - {type: ball, bodies: [a, b], anchor: [1, 0, 0]}
events: [{do: release, bodies: a, when: {time: 0.5}}]
)");
      run.frames(50);
      EXPECT_EQ(run.position(0), Vec3(1, 0, 0));
      EXPECT_NEAR((run.position(1) - Vec3(1, 0, 0)).norm(), 1, 1e-3);
      EXPECT_LT(run.position(1).z(), -0.3);
      run.frames(30);
      EXPECT_TRUE(run.finite());
      EXPECT_LT(run.position(0).z(), -0.05);
      EXPECT_NEAR(run.position(0).norm(), 1, 1e-3);
    }
}

// A held body that lies in what is fixed has nowhere to go, and one that others fall on holds them.
TEST(Events, HeldBodiesHoldOthers) {
  Changing run(R"(
time: {frame: 0.01, frames: 100}
bodies:
  - {shape: {plane: {normal: [0, 0, 1]}}}
  - {name: a, shape: {box: {size: [0.2, 0.2, 0.2]}}, mass: 1, position: [0, 0, 0.05], start: held}
  - {name: b, shape: {box: {size: [0.1, 0.1, 0.1]}}, mass: 5, position: [0, 0, 0.2]}
  - {name: c, shape: {box: {size: [0.2, 0.2, 0.2]}}, mass: 1, position: [0, 0, 1], start: held}
events: [{do: remove, bodies: b, when: {time: 0.6}}]
)");
  run.frames(60);
  EXPECT_EQ(run.position(1), Vec3(0, 0, 0.05));
  EXPECT_NEAR(run.position(2).z(), 0.2, 1e-6);
  EXPECT_TRUE(run.last.converged);
}

}  // namespace

}  // namespace unibody::small_worlds::events_test
