// However few the iterations, the Jacobi solvers lose no body through a floor or a wall; with the same bits on any number of
// ranks. The first rank runs each scene alone as well.
#include <gtest/gtest.h>

#include <array>
#include <string>
#include <utility>
#include <vector>

#include "partition/ranks.hpp"
#include "report/state_hash.hpp"
#include "small_worlds.hpp"

namespace unibody::small_worlds::ranks_settle_test {

namespace {

// A column twenty boxes high: its weight is more than four iterations can carry.
std::string column(const std::string& solver, const std::string& ground) {
  return R"(
materials: {wood: {friction: 0.3}}
bodies:
  - )" + ground +
         R"(
  - lattice: {count: 160, columns: [2, 4], spacing: [0.13, 0.13, 0.13], height: 0.1, jitter: 0.004}
    shape: {box: {size: [0.12, 0.12, 0.12]}}
    mass: 1
solver: {iterations: 4, name: )" +
         solver + "}";
}

// Rods and tetrahedra above a plane that hit it in the first steps, at angles at which the end that is stopped throws the rest
// down; and others on their backs.
std::string hail(int iterations) {
  return "materials: {wood: {friction: 0.3}}\nsolver: {iterations: " + std::to_string(iterations) + R"(}
bodies:
  - shape: {plane: {normal: [0, 0, 1]}}
  - lattice: {count: 50, columns: [5, 5], spacing: [0.5, 0.5, 0.2], height: 0.5, rotation_jitter: 1}
    shape: {box: {size: [0.4, 0.02, 0.02]}}
    mass: 1
    velocity: [0, 0, -20]
  - lattice: {count: 25, columns: [5, 5], spacing: [0.5, 0.5, 0.5], height: 1, rotation_jitter: 1}
    shape: {hull: {points: [[0, 0, 0], [0.1, 0, 0], [0, 0.1, 0], [0, 0, 0.1]]}}
    mass: 1
    velocity: [0, 0, -20]
  - lattice: {count: 25, columns: [5, 5], spacing: [0.5, 0.5, 0.5], height: 0.3, rotation_jitter: 1}
    shape: {box: {size: [0.4, 0.02, 0.02]}}
    mass: 1
    velocity: [0, 0, -2]
)";
}

// Steps the scene on one rank, looking at the world after each step, then on all ranks: both end in the same state.
template <class Look>
void expect_the_state_of_one_rank(const std::string& text, int steps, Look&& look) {
  Experiment run(scene_from_text(text));  // on all ranks: shapes are numbered as they are read
  const auto alone = of_first_rank([&] {
    for (int step = 0; step < steps; ++step) run.step(), look(run.world(), step);
    return std::vector<std::uint64_t>{state_hash(MPI_COMM_SELF, run.world())};
  });
  if (rank_count() == 1) return;  // it would be the same run again
  Experiment together(scene_from_text(text), MPI_COMM_WORLD);
  together.steps(steps);
  EXPECT_EQ(alone.front(), state_hash(MPI_COMM_WORLD, together.world()));
}

}  // namespace

// One rank runs all, and each larger number of ranks one of them.
TEST(RanksSettle, NoCentreGoesThroughAPlaneAtImpact) {
  for (const int iterations : {4, 10, 20}) {
    if (rank_count() > 1 && iterations != std::array{4, 10, 20}[static_cast<std::size_t>(rank_count() - 2) % 3]) continue;
    SCOPED_TRACE(iterations);
    expect_the_state_of_one_rank(hail(iterations), 30, [](const World& world, int step) {
      for (std::size_t i = 0; i < world.homes; ++i)
        ASSERT_GT(world.position[i].z(), 0) << "body " << world.id[i] << ", step " << step;
    });
  }
}

// Each column takes seconds: a run on one rank steps all three columns, and a run on more ranks the first half of one of them.
TEST(RanksSettle, NoCentreIsEverBehindWhatDoesNotMove) {
  const std::string plane = "shape: {plane: {normal: [0, 0, 1]}}", container = "container: {size: [0.32, 0.58]}";
  const std::vector<std::pair<std::string, std::string>> columns{
      {"accelerated_jacobi", plane}, {"accelerated_jacobi", container}, {"jacobi", container}};
  for (std::size_t k = 0; k < columns.size(); ++k) {
    if (rank_count() > 1 && k != static_cast<std::size_t>(rank_count() - 2) % columns.size()) continue;
    const auto& [solver, ground] = columns[k];
    SCOPED_TRACE(solver + ", " + ground);
    const bool walls = ground == container;
    expect_the_state_of_one_rank(column(solver, ground), rank_count() > 1 ? 20 : 40, [walls](const World& world, int step) {
      for (std::size_t i = 0; i < world.homes; ++i) {
        const Vec3& x = world.position[i];
        ASSERT_GT(x.z(), 0) << "body " << world.id[i] << " in step " << step;
        if (!walls) continue;
        ASSERT_LT(std::abs(x.x()), 0.16) << "body " << world.id[i] << " in step " << step;
        ASSERT_LT(std::abs(x.y()), 0.29) << "body " << world.id[i] << " in step " << step;
      }
    });
  }
}

}  // namespace unibody::small_worlds::ranks_settle_test
