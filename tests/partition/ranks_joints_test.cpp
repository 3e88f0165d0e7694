// Joints across ranks: a chain of which every link is on another rank than its neighbours, the same bits as on one.
#include <gtest/gtest.h>

#include <map>

#include "partition/balance.hpp"
#include "partition/ranks.hpp"
#include "small_worlds.hpp"
#include "step/step_parts.hpp"

namespace unibody::small_worlds::ranks_joints_test {

namespace {

// A chain with a heavy ball that swings into a wall, a door on two hinges, a motor, a rope between bodies far apart, and a
// kinematic body that drags.
std::string machine(const std::string& solver, const std::string& joints) {
  return R"(
bodies:
  - {name: wall, shape: {box: {size: [0.2, 4, 4]}}, motion: fixed, position: [-0.7, 0, -1]}
  - {name: arm, shape: {box: {size: [1, 0.1, 0.1]}}, motion: kinematic, position: [0, 3, 0], angular_velocity: [0, 0, 2]}
  - {name: load, shape: {sphere: {radius: 0.1}}, mass: 1, position: [0.6, 3, 0]}
  - {name: door, shape: {box: {size: [0.9, 0.04, 2]}}, mass: 20, position: [3, 0, 0]}
  - {name: weight, shape: {box: {size: [0.3, 0.2, 0.2]}}, mass: 3, position: [3, 6, 0]}
  - name: chain
    shape: {box: {size: [0.09, 0.03, 0.02]}}
    mass: 0.1
    chain: {count: 14, from: [0, 0, 0], to: [1, 0, -1], held: start, joint: {type: universal, axis: [0, 1, 0], second_axis: [1, 0, 0]}, ball: {radius: 0.1, mass: 2}}
joints:
  - {type: fixed, bodies: [load, arm], anchor: [0.5, 3, 0]}
  - {type: hinge, bodies: [door, world], anchor: [2.55, 0, -0.8], axis: [0, 0, 1], friction: 0.1, limits: [-60, 60]}
  - {type: hinge, bodies: [door, world], anchor: [2.55, 0, 0.8], axis: [0, 0, 1], motor: {speed: 3, max_torque: 30}}
  - {type: rope, bodies: [weight, door], points: [[3, 6, 0], [3.4, 0, 0]], length: 6.1}
solver: {iterations: 12, name: )" +
         solver + ", joints: " + joints + "}\n";
}

void spread(Experiment& run, std::uint64_t seed) {
  run.simulation->move_homes(Balance(MPI_COMM_WORLD, seed, false).homes(parts_of(*run.simulation)));
}

}  // namespace

TEST(RanksJoints, AMachineHasTheBitsOfOneRank) {
  for (const auto& [solver, joints] : {std::pair("accelerated_jacobi", "iterative"),
                                       {"jacobi", "iterative"},
                                       {"gauss_seidel", "iterative"},
                                       {"accelerated_jacobi", "direct"},
                                       {"gauss_seidel", "direct"}}) {
    Experiment alone(scene_from_text(machine(solver, joints)));
    Experiment run(scene_from_text(machine(solver, joints)), MPI_COMM_WORLD);
    spread(run, 5);
    const World& w = run.world();
    for (int k = 0; k < 90; ++k) {
      if (k == 30) run.simulation->detect(), spread(run, 17);  // joints and their impulses travel
      alone.step(), run.step();
      ASSERT_EQ(run.last.residual_of<JointBatch>(), alone.last.residual_of<JointBatch>()) << solver << ' ' << k;
      for (std::size_t i = 0; i < w.homes; ++i) {
        const BodyState here = w.state(i), there = alone.state(w.id[i]);
        ASSERT_EQ(here.position, there.position) << solver << ' ' << k << ' ' << w.id[i];
        ASSERT_EQ(here.orientation.coeffs(), there.orientation.coeffs()) << solver << ' ' << k << ' ' << w.id[i];
        ASSERT_EQ(here.angular_velocity, there.angular_velocity) << solver << ' ' << k << ' ' << w.id[i];
      }
    }
    // Each rank's joints are those of its bodies, and each is counted once.
    int counted = 0;
    for (const JointSlots& s : run.simulation->ties.joint_slots) counted += s.counted;
    MPI_Allreduce(MPI_IN_PLACE, &counted, 1, MPI_INT, MPI_SUM, MPI_COMM_WORLD);
    EXPECT_EQ(counted, static_cast<int>(run.scene->joints.size()));
    double drift = 0;
    for (const JointState& s : alone.simulation->joint_states()) drift = std::max(drift, s.drift);
    EXPECT_LT(drift, 0.2) << "such a run tells nothing";
    EXPECT_EQ(w.guests > 0, rank_count() > 1);
  }
}

// The graph that METIS cuts knows of joints: two rows of beads that are tied across, far apart, are not parted from each other.
TEST(RanksJoints, ThePartitionKeepsJointedBodiesTogether) {
  std::string text = "gravity: [0, 0, 0]\nbodies:\n";
  constexpr int n = 64;
  for (int i = 0; i < n; ++i)
    text += "  - {name: b" + std::to_string(i) + ", shape: {sphere: {radius: 0.1}}, mass: 1, position: [" +
            std::to_string(50.0 * i) + ", 0, 0]}\n";
  text += "joints:\n";  // body i with body i + 1 for even i, and with no other
  for (int i = 0; i < n; i += 2)
    text += "  - {type: rope, bodies: [b" + std::to_string(i) + ", b" + std::to_string(i + 1) +
            "], anchors: [[0, 0, 0], [0, 0, 0]]}\n";
  Experiment run(scene_from_text(text), MPI_COMM_WORLD);
  Simulation& s = *run.simulation;
  const Balance balance(MPI_COMM_WORLD, {}, true);
  for (int k = 0; k < 2; ++k) {
    s.detect();
    s.move_homes(balance.homes(parts_of(s)));
  }
  s.detect();
  EXPECT_EQ(s.world.guests, 0u) << "no joint is cut";
}

}  // namespace unibody::small_worlds::ranks_joints_test
