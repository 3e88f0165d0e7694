// Joints solved as trees: tensions of heavy chains, momentum, and the same steps as of the iterative solve that converges.
#include <gtest/gtest.h>

#include <cmath>

#include "small_worlds.hpp"

namespace unibody::small_worlds::joint_trees_test {

namespace {

const char* const solver_list[] = {"accelerated_jacobi", "jacobi", "gauss_seidel"};

std::string settings(const std::string& solver, int iterations, double step, const std::string& joints) {
  return "solver: {name: " + solver + ", iterations: " + std::to_string(iterations) +
         ", tolerance: 0, stages: position, joints: " + joints + "}\ntime: {frame: " + std::to_string(step) + "}\n";
}

double largest_drift(const Experiment& run) {
  double drift = 0;
  for (const JointState& s : run.simulation->joint_states()) drift = std::max(drift, s.drift);
  return drift;
}

}  // namespace

// 100 links, and a ball of 10^3 and 10^6 times a link's mass: the joint above link i carries (M + (n - i) m) g.
TEST(JointTree, AHeavyBallHangsOnAHundredLinks) {
  for (const char* solver : solver_list)
    for (const double ball : {100.0, 1e5}) {
      Experiment run(scene_from_text(R"(
bodies:
  - shape: {box: {size: [0.09, 0.03, 0.03]}}
    mass: 0.1
    chain: {count: 100, from: [0, 0, 0], to: [0, 0, -10], held: start, joint: {type: ball}, ball: {radius: 0.3, mass: )" +
                                     std::to_string(ball) + "}}\n" + settings(solver, 10, 0.016, "direct")));
      run.steps(20);
      const auto states = run.simulation->joint_states();
      for (std::size_t i = 0; i < states.size(); ++i) {
        const double carried = ball + 0.1 * (100 - static_cast<double>(i));
        ASSERT_NEAR(states[i].force.z() / (carried * 9.81), 1, 1e-6) << solver << ' ' << ball << ' ' << i;
      }
      EXPECT_LT(largest_drift(run), 1e-9) << solver << ' ' << ball;
    }
}

// In motion, too, a few iterations close what hundreds of the other kind leave open.
TEST(JointTree, AChainThatSwingsStaysClosed) {
  const auto worst = [](const char* solver, int iterations, const char* joints) {
    Experiment run(scene_from_text(R"(
bodies:
  - shape: {box: {size: [0.1, 0.02, 0.02]}}
    mass: 0.1
    chain: {count: 20, from: [0, 0, 0], to: [1, 0, -1.73], held: start, joint: {type: ball}, ball: {radius: 0.1, mass: 50}}
)" + settings(solver, iterations, 0.016, joints)));
    double drift = 0;
    for (int k = 0; k < 30; ++k) run.step(), drift = std::max(drift, largest_drift(run));
    return drift;
  };
  const double iterative = worst("accelerated_jacobi", 200, "iterative");
  EXPECT_GT(iterative, 1e-5) << "such a chain tells nothing";
  for (const char* solver : solver_list) EXPECT_LT(worst(solver, 12, "direct"), 1e-7) << solver;
}

// Two jointed bodies, free, at any step that resolves their motion: neither momentum changes.
TEST(JointTree, MomentumStaysAtAnyStep) {
  for (const char* joints : {"iterative", "direct"})
    for (const char* solver : solver_list)
      for (const char* type :
           {"ball", "fixed", "hinge, axis: [0, 0, 1]", "universal, axis: [0, 0, 1]", "slider, axis: [1, 0, 0]"})
        for (const double h : {0.001, 0.016, 0.1, 0.5}) {
          Experiment run(scene_from_text(std::string(R"(
gravity: [0, 0, 0]
bodies:
  - {name: a, shape: {box: {size: [1, 0.2, 0.3]}}, mass: 2, velocity: [0.3, 0.02, 0]}
  - {name: b, shape: {sphere: {radius: 0.2}}, mass: 1, position: [1, 0, 0], velocity: [0.3, -0.04, 0]}
joints: [{type: )") + type + ", bodies: [a, b], anchor: [0.5, 0, 0]}]\n" +
                                         settings(solver, 60, h, joints)));
          const Vec3 p = run.momentum(), l = run.angular_momentum();
          const double energy = run.kinetic_energy();
          run.steps(60);
          EXPECT_LT((run.momentum() - p).norm(), 1e-13) << solver << ' ' << type << ' ' << h << ' ' << joints;
          EXPECT_LT((run.angular_momentum() - l).norm(), 1e-12 * std::max(1.0, run.position(0).norm()))
              << solver << ' ' << type << ' ' << h << ' ' << joints;
          EXPECT_LT(run.kinetic_energy(), 1.001 * energy) << solver << ' ' << type << ' ' << h << ' ' << joints;
        }
}

// A machine of a tree, a loop, limits, a motor and contacts: both ways lead to the same steps where they converge.
TEST(JointTree, ConvergesToWhatTheIterativeSolveDoes) {
  const auto machine = [](const char* solver, int iterations, const char* joints) {
    return std::string(R"(
bodies:
  - {shape: {plane: {normal: [0, 0, 1]}}}
  - {name: a, shape: {box: {size: [0.4, 0.2, 0.2]}}, mass: 2, position: [0, 0, 0.102]}
  - {name: b, shape: {box: {size: [0.2, 0.1, 0.1]}}, mass: 1, position: [0.35, 0, 0.15]}
  - {name: c, shape: {box: {size: [0.2, 0.1, 0.1]}}, mass: 1, position: [0.6, 0, 0.15]}
  - {name: d, shape: {sphere: {radius: 0.05}}, mass: 0.5, position: [0, 0, 0.3]}
joints:
  - {type: hinge, bodies: [b, a], anchor: [0.22, 0, 0.15], axis: [0, 1, 0], motor: {speed: 0.5, max_torque: 0.4}}
  - {type: universal, bodies: [c, b], anchor: [0.48, 0, 0.15], axis: [0, 1, 0], second_axis: [0, 0, 1]}
  - {type: ball, bodies: [c, a], anchors: [[-0.35, 0, 0], [0.25, 0, 0.048]], compliance: 1.0e-4}
  - {type: ball, bodies: [d, a], anchor: [0, 0, 0.2], axis: [0, 0, 1], swing_limit: 20}
)") + settings(solver, iterations, 0.008, joints);
  };
  for (const char* solver : {"accelerated_jacobi", "gauss_seidel"}) {
    Experiment one(scene_from_text(machine(solver, 4000, "iterative"))), other(scene_from_text(machine(solver, 1500, "direct")));
    one.steps(15), other.steps(15);
    for (Id id = 1; id <= 4; ++id) EXPECT_LT((one.position(id) - other.position(id)).norm(), 1e-5) << solver << ' ' << id;
    EXPECT_LT(largest_drift(other), 2e-3) << solver;
  }
}

}  // namespace unibody::small_worlds::joint_trees_test
