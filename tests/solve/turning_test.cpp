// What constraints between centres miss because their directions turn within the step, and steps that go on in the total form.
#include <gtest/gtest.h>

#include "report/state_hash.hpp"
#include "small_worlds.hpp"

namespace unibody::small_worlds::turning_test {

namespace {

// A thread of ten stiff links swings down from the horizontal, pinned at one end.
std::string swinging_thread(const std::string& solver) {
  return "solver: {" + solver +
         "}\nthreads:\n  - points: [[0, 0, 0], [1, 0, 0]]\n    segments: 10\n    radius: 0.005\n    mass: 0.1\n"
         "    pins: [{node: 0}]\n";
}

// A sheet of soft springs on a ball, with a ball on it: contacts of nodes, of faces and of a pin to a dynamic body.
std::string laden_sheet(const std::string& solver) {
  return "solver: {" + solver +
         "}\nbodies:\n  - {shape: {sphere: {radius: 0.3}}, motion: fixed, position: [0, 0, -0.32]}\n"
         "  - {name: load, shape: {sphere: {radius: 0.05}}, mass: 0.2, position: [0, 0, 0.07]}\n"
         "  - {name: weight, shape: {sphere: {radius: 0.05}}, mass: 0.2, position: [0.5, 0.5, -0.05]}\n"
         "cloths:\n  - grid: {size: [1, 1], nodes: [9, 9]}\n    mass: 0.5\n    thickness: 0.02\n"
         "    links: {stiffness: 200, damping: 0.02}\n    pins: [{node: [8, 8], to: weight}, {node: [0, 0]}]\n";
}

const std::string solver_list[] = {"accelerated_jacobi", "jacobi", "gauss_seidel"};

}  // namespace

// By hand, from the multipliers that the step leaves: the largest h |v~ + (sum of impulses) / m - v| of a node.
TEST(Turning, IsWhatTheImpulsesMiss) {
  for (const std::string& solver : solver_list) {
    Experiment run(scene_from_text(swinging_thread("iterations: 10, name: " + solver)));
    run.steps(20);
    const std::vector<Vec3> before(run.world().velocity.begin(), run.world().velocity.end());
    run.step();
    std::vector<Vec3> impulse(before.size(), Vec3::Zero());
    const auto& links = std::get<ConstraintList<Distance>>(run.simulation->ties.constraints);
    const auto& multipliers = run.simulation->history.of<ConstraintBatch<Distance>>();
    ASSERT_EQ(links.size(), 10u);
    for (std::size_t k = 0; k < links.size(); ++k) {
      const Vec3 along = (run.position(links[k].ids[0]) - run.position(links[k].ids[1])).normalized();
      impulse[static_cast<std::size_t>(links[k].ids[0])] += multipliers[k][0] * along;
      impulse[static_cast<std::size_t>(links[k].ids[1])] -= multipliers[k][0] * along;
    }
    double missed = 0;
    for (std::size_t i = 0; i < before.size(); ++i) {
      if (run.world().properties[i].motion != Motion::dynamic) continue;
      const Vec3 right = before[i] + run.h() * run.scene->gravity + impulse[i] / run.world().properties[i].mass;
      missed = std::max(missed, run.h() * (right - run.world().velocity[i]).norm());
    }
    EXPECT_GT(missed, 1e-5) << solver;
    EXPECT_NEAR(run.last.turning, missed, 1e-9 * missed) << solver;
    EXPECT_FALSE(run.last.converged) << solver;
  }
}

// Rows that are within the tolerance do not make a step converged whose impulses miss more than that.
TEST(Turning, CountsForConvergence) {
  for (const std::string& solver : solver_list) {
    Experiment run(scene_from_text(swinging_thread("iterations: 40, tolerance: 1.0e-3, name: " + solver)));
    int solved_rows = 0;
    for (int k = 0; k < 60; ++k) {
      const StepReport step = run.step();
      EXPECT_EQ(step.converged, step.residual <= 1e-3 && step.turning <= 1e-3) << solver << ' ' << k;
      solved_rows += step.residual <= 1e-3;
    }
    EXPECT_GT(solved_rows, 0) << solver;
  }
}

// Among contacts and pins too a converged step misses nothing, and stays within the tolerance that it says.
TEST(Turning, IsTakenOutAmongContacts) {
  for (const std::string solver : {"accelerated_jacobi", "gauss_seidel"}) {
    Experiment run(scene_from_text(laden_sheet("iterations: 4000, tolerance: 1.0e-7, name: " + solver)));
    int converged = 0, touching = 0;
    for (int k = 0; k < 40; ++k) {
      const StepReport step = run.step();
      converged += step.converged;
      touching += !run.simulation->contacts.surface.empty();
      EXPECT_LE(step.converged ? step.turning : 0, 1e-7) << solver << ' ' << k;
    }
    EXPECT_GT(converged, 10) << solver;
    EXPECT_GT(touching, 20) << solver;
  }
}

// The ranks agree on when a step goes on in the total form, and on all that it does then.
TEST(RanksTurning, HasTheSameStepsOnAnyNumberOfRanks) {
  for (const std::string solver : {"accelerated_jacobi", "gauss_seidel"}) {
    const std::string settings = "iterations: 400, tolerance: 1.0e-6, name: " + solver;
    Experiment all(scene_from_text(laden_sheet(settings)), MPI_COMM_WORLD), alone(scene_from_text(laden_sheet(settings)));
    for (int k = 0; k < 25; ++k) {
      all.step(), alone.step();
      ASSERT_EQ(all.last.turning, alone.last.turning) << solver << ' ' << k;
      ASSERT_EQ(all.last.iterations, alone.last.iterations) << solver << ' ' << k;
    }
    EXPECT_EQ(state_hash(MPI_COMM_WORLD, all.world()), state_hash(MPI_COMM_SELF, alone.world())) << solver;
  }
}

}  // namespace unibody::small_worlds::turning_test
