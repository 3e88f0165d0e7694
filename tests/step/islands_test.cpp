// Which islands have constraints: on one rank, and where an island reaches over several.
#include "step/islands.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "report/state_hash.hpp"
#include "small_worlds.hpp"
#include "step/assemble.hpp"
#include "step/detect.hpp"
#include "step/steadying.hpp"

namespace unibody::small_worlds::islands_test {

namespace {

std::vector<std::int32_t> marks_of(Experiment& run) {
  System system(&run.simulation->scratch);
  run.simulation->detect();
  build_lasting(*run.simulation, system);
  predict(*run.simulation, system);
  std::vector<double> geometric_stiffness = geometric_stiffness_of_joints(*run.simulation);
  assemble(*run.simulation, system, geometric_stiffness);
  return constrained_islands(*run.simulation, system);
}

// Balls that touch, in a row along x from one end of the scene to the other; the last one hangs on a joint.
std::string row(int balls, const std::string& solver) {
  std::string points;
  for (int k = 0; k < balls; ++k) points += (k > 0 ? ", [" : "[") + std::to_string(0.0999 * k) + ", 0, 0.05]";
  return "solver: {name: " + solver +
         "}\nbodies:\n  - {shape: {plane: {normal: [0, 0, 1]}}}\n  - {shape: {sphere: {radius: 0.05}}, mass: 1, points: [" +
         points + "]}\n  - {shape: {sphere: {radius: 0.05}}, mass: 1, name: last, position: [" + std::to_string(0.0999 * balls) +
         ", 0, 0.05]}\n  - {shape: {sphere: {radius: 0.05}}, mass: 1, points: [[0, 3, 0.05], [0, 3, 0.1499]]}\n"
         "joints:\n  - {type: ball, bodies: [last, world], anchor: [" +
         std::to_string(0.0999 * balls) + ", 0, 0.5]}\n";
}

}  // namespace

TEST(Islands, AConstraintMarksAllThatTouchOneAnotherButNotThroughTheGround) {
  Experiment run(scene_from_text(row(6, "accelerated_jacobi")));
  const std::vector<std::int32_t> marks = marks_of(run);
  EXPECT_EQ(marks[run.slot(0)], 0) << "the ground";
  for (Id id = 1; id <= 7; ++id) EXPECT_EQ(marks[run.slot(id)], 1) << id;
  for (Id id = 8; id <= 9; ++id) EXPECT_EQ(marks[run.slot(id)], 0) << id;
}

TEST(RanksIslands, AMarkGoesFromRankToRank) {
  Experiment run(scene_from_text(row(40, "accelerated_jacobi")), MPI_COMM_WORLD);
  const std::vector<std::int32_t> marks = marks_of(run);
  for (std::size_t i = 0; i < run.world().homes; ++i)
    EXPECT_EQ(marks[i], run.world().position[i].y() > 1 ? 0 : 1) << "body " << run.world().id[i];
}

// 41 balls of 20 ns, 40 pairs of them and 41 with the ground of 25 ns, and three rows of a joint of 400 ns fill half a
// millisecond in 123 iterations; the two other balls have as many as there may be.
TEST(RanksIslands, EachKindHasIterationsByWhatItCosts) {
  Experiment run(scene_from_text(row(40, "accelerated_jacobi")), MPI_COMM_WORLD);
  const StepReport report = run.simulation->step();
  ASSERT_EQ(report.plans.size(), 2U);
  EXPECT_EQ(report.plans[0].iterations, 500'000 / (41 * 20 + 81 * 25 + 3 * 400));
  EXPECT_EQ(report.plans[1].iterations, 1000);
}

// Balls that fall on two that a joint holds together, and slide off them; and two that fall on each other elsewhere.
TEST(RanksIslands, SolvedApartTheyEndWithTheSameBits) {
  const std::string falling =
      "materials: {m: {friction: 0.3}}\nbodies:\n  - {shape: {plane: {normal: [0, 0, 1]}}, material: m}\n"
      "  - {shape: {sphere: {radius: 0.05}}, mass: 1, material: m, points: [[0, 0, 0.5], [0, 0, 0.8], [1, 0, 0.5], [1.02, 0, "
      "0.7]]}\n"
      "  - {shape: {sphere: {radius: 0.05}}, mass: 1, name: j, material: m, position: [0, 0, 0.2]}\n"
      "  - {shape: {sphere: {radius: 0.05}}, mass: 1, name: k, material: m, position: [0.2, 0, 0.2]}\n"
      "joints:\n  - {type: ball, bodies: [j, k], anchor: [0.1, 0, 0.2]}\n";
  for (const char* solver : {"accelerated_jacobi", "jacobi", "gauss_seidel"})
    for (const std::string& scene : {row(12, solver), "solver: {name: " + std::string(solver) + "}\n" + falling}) {
      Experiment alone(scene_from_text(scene)), together(scene_from_text(scene), MPI_COMM_WORLD);
      alone.steps(200), together.steps(200);
      EXPECT_EQ(state_hash(MPI_COMM_SELF, alone.world()), state_hash(MPI_COMM_WORLD, together.world())) << solver;
    }
}

}  // namespace unibody::small_worlds::islands_test
