// A kind of constraint that is named in the list of batches, and nowhere else, takes part in all that a step and a run do.
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <filesystem>

#include "checkpoint/checkpoint.hpp"
#include "scene/scene_text.hpp"
#include "step/build.hpp"
#include "step/move_history.hpp"
#include "step/simulation.hpp"

namespace unibody::spring_test {
namespace {

constexpr double h = 0.01, mass = 2;

// Body 0 on the springs, without gravity; far away two others touch, and a joint ties two, at rest: in a scene without a
// constraint beside contacts nothing starts from old multipliers but contacts.
std::string spheres(const std::string& solver, int iterations, const std::string& tolerance) {
  return "gravity: [0, 0, 0]\ntime: {frame: 0.01}\nsolver: {name: " + solver + ", iterations: " + std::to_string(iterations) +
         ", stages: position, tolerance: " + tolerance +
         "}\nbodies:\n"
         "  - {shape: {sphere: {radius: 0.1}}, mass: 2, position: [0.5, 0.2, 9]}\n"
         "  - {shape: {sphere: {radius: 0.1}}, mass: 1, position: [2, 0, 1]}\n"
         "  - {shape: {sphere: {radius: 0.1}}, mass: 1, position: [2.19, 0, 1], velocity: [-1, 0, 0]}\n"
         "  - {shape: {sphere: {radius: 0.1}}, mass: 1, position: [5, 3, 1], name: post}\n"
         "  - {shape: {sphere: {radius: 0.1}}, mass: 1, position: [5, 4, 1], name: arm}\n"
         "joints:\n  - {type: ball, bodies: [post, arm], anchor: [5, 3.5, 1]}\n";
}

struct SpringRun {
  SpringRun(MPI_Comm comm, const std::string& text) : scene(scene_from(text)), simulation(comm, scene, clock, true) {
    simulation.world = build_world(comm, scene);
    simulation.resolve_automatic_settings();
  }
  void steps(int n) {
    for (int k = 0; k < n; ++k) last = simulation.step();
  }
  // x, y and their velocities of body 0, from the rank that has it. Collective.
  std::array<double, 4> motion() const {
    std::array<double, 4> own{-HUGE_VAL, -HUGE_VAL, -HUGE_VAL, -HUGE_VAL};
    const World& world = simulation.world;
    if (const Slot slot = world.find(0); slot >= 0 && world.is_home(slot))
      own = {world.position[static_cast<std::size_t>(slot)].x(), world.position[static_cast<std::size_t>(slot)].y(),
             world.velocity[static_cast<std::size_t>(slot)].x(), world.velocity[static_cast<std::size_t>(slot)].y()};
    MPI_Allreduce(MPI_IN_PLACE, own.data(), 4, MPI_DOUBLE, MPI_MAX, simulation.comm());
    return own;
  }

  PhaseClock clock;
  const Scene scene;
  Simulation simulation;
  StepReport last;
};

const std::string solvers[] = {"accelerated_jacobi", "jacobi", "gauss_seidel"};

}  // namespace

// Implicit Euler of a mass on springs: (1 + h^2 K / m) v' = v - h K x / m, x' = x + h v', K the sum of k d d^T over the springs.
TEST(ExtraBatch, MovesAsInClosedForm) {
  Eigen::Matrix2d K = Eigen::Matrix2d::Zero();
  for (const auto& direction : SpringBatch::directions) {
    const Eigen::Vector2d d(direction[0], direction[1]);
    K += SpringBatch::stiffness / mass * d * d.transpose();
  }
  const Eigen::Matrix2d step = (Eigen::Matrix2d::Identity() + h * h * K).inverse();
  for (const std::string& solver : solvers) {
    SpringRun run(MPI_COMM_WORLD, spheres(solver, 400, "0"));
    Eigen::Vector2d x(0.5, 0.2), v(0, 0);
    for (int k = 0; k < 30; ++k) {
      run.steps(1);
      v = step * (v - h * K * x), x += h * v;
      EXPECT_LE(run.last.residual_of<SpringBatch>(), 1e-12) << solver << ' ' << k;
      const std::array<double, 4> found = run.motion();
      for (int i = 0; i < 2; ++i) {
        EXPECT_NEAR(found[i], x[i], 1e-11) << solver << ' ' << k;
        EXPECT_NEAR(found[2 + i], v[i], 1e-9) << solver << ' ' << k;
      }
    }
  }
}

// Few iterations leave a step short of converged, so that what it started from shows.
TEST(ExtraBatch, IsTheSameOnAnyNumberOfRanksAndMovesWithItsBody) {
  for (const std::string& solver : solvers) {
    const std::string text = spheres(solver, 2, "0");
    SpringRun alone(MPI_COMM_SELF, text), together(MPI_COMM_WORLD, text);
    int ranks = 1;
    MPI_Comm_size(MPI_COMM_WORLD, &ranks);
    for (int k = 0; k < 12; ++k) {
      alone.steps(1), together.steps(1);
      EXPECT_GT(together.last.residual_of<SpringBatch>(), 1e-9) << "nothing is left to show what a step started from";
      EXPECT_EQ(alone.motion(), together.motion()) << solver << ' ' << k;
      std::vector<int> home;
      for (std::size_t i = 0; i < together.simulation.world.homes; ++i)
        home.push_back(static_cast<int>((together.simulation.world.id[i] + k) % ranks));
      together.simulation.detect();
      together.simulation.move_homes(home);
    }
  }
}

TEST(ExtraBatch, GoesOnFromACheckpoint) {
  const std::string path = std::filesystem::temp_directory_path() / "unibody_extra_batch.h5";
  for (const std::string& solver : solvers) {
    const std::string text = spheres(solver, 2, "0");
    SpringRun whole(MPI_COMM_WORLD, text);
    whole.steps(6);
    write_checkpoint(MPI_COMM_WORLD, path, "0123", 6, 6 * h, 6, whole.simulation.elements(), whole.simulation.history);
    whole.steps(6);
    std::array<std::array<double, 4>, 2> found;
    for (const bool with_history : {true, false}) {
      SpringRun second(MPI_COMM_WORLD, text);
      Simulation& s = second.simulation;
      const Checkpoint checkpoint(MPI_COMM_WORLD, path, "0123");
      for (std::size_t i = 0; i < s.world.homes; ++i)
        s.world.set_state(i, checkpoint.read_bodies(s.world.id[i], s.world.id[i] + 1)[0].state);
      s.history.contacts() = checkpoint.read_multipliers(s.world);
      s.make_constraints(), s.when.steps_done = 6;
      if (with_history) checkpoint.read_histories(s.elements(), s.history);
      second.steps(6);
      found[with_history] = second.motion();
    }
    EXPECT_EQ(found[true], whole.motion()) << solver;
    EXPECT_NE(found[false], whole.motion()) << "the history changes nothing";
  }
}

}  // namespace unibody::spring_test
