// The same bits on any number of ranks: the first rank runs the scene alone as well.
#include <gtest/gtest.h>

#include "partition/balance.hpp"
#include "partition/ranks.hpp"
#include "report/state_hash.hpp"
#include "small_worlds.hpp"
#include "step/step_parts.hpp"

namespace unibody::small_worlds::ranks_bitwise_test {

namespace {

// 150 boxes and spheres of sizes 1 : 3 and a kinematic paddle between walls.
std::string mixed_scene(const std::string& solver) {
  return R"(
bodies:
  - container: {size: [0.9, 0.9]}
  - pile:
      count: 150
      columns: [4, 4]
      seed: 7
      mix:
        - {shape: {sphere: {radius: 0.06}}, scale: [0.5, 1.5]}
        - {shape: {box: {size: [0.12, 0.1, 0.08]}}, scale: [0.5, 1.5]}
    density: 1000
    velocity: [0, 0, -3]
    position: [0, 0, 0.02]
  - shape: {box: {size: [0.5, 0.1, 0.3]}}
    motion: kinematic
    position: [0, 0, 0.15]
    angular_velocity: [0, 0, 2]
solver: )" +
         solver;
}

const std::string solvers[] = {"{name: accelerated_jacobi, iterations: 12}",
                               "{name: jacobi, iterations: 12}",
                               "{name: gauss_seidel, iterations: 8}",
                               "{name: accelerated_jacobi, iterations: 8, gap: reevaluated}",
                               "{name: accelerated_jacobi, stages: position, iterations: 8, friction: cone}",
                               "{name: accelerated_jacobi, iterations: 8, friction: postprocess}",
                               "{name: gauss_seidel, iterations: 8, friction: postprocess}"};

constexpr int looks[] = {1, 10, 30};

std::vector<std::uint64_t> alone(const std::string& text) {
  Experiment run(scene_from_text(text));  // on all ranks: shapes are numbered as they are read
  return of_first_rank([&] {
    std::vector<std::uint64_t> hashes;
    int done = 0;
    for (const int look : looks) {
      run.steps(look - done), done = look;
      hashes.push_back(state_hash(MPI_COMM_SELF, run.world()));
    }
    return hashes;
  });
}

std::vector<std::uint64_t> together(const std::string& text, std::optional<std::uint64_t> seed, int migrate_every) {
  Experiment run(scene_from_text(text), MPI_COMM_WORLD);
  Balance balance(MPI_COMM_WORLD, seed, true);
  Simulation& s = *run.simulation;
  s.move_homes(balance.homes(parts_of(s)));
  std::vector<std::uint64_t> hashes;
  int done = 0;
  for (const int look : looks)
    for (; done < look;) {
      run.step(), ++done;
      if (migrate_every > 0 && done % migrate_every == 0) {
        s.detect();
        const Balance other(MPI_COMM_WORLD, seed ? std::optional(*seed + static_cast<std::uint64_t>(done)) : std::nullopt, true);
        s.move_homes(other.homes(parts_of(s)));
      }
      if (done == look) hashes.push_back(state_hash(MPI_COMM_WORLD, s.world));
    }
  return hashes;
}

}  // namespace

// Cloths of both models, a thread and boxes that fall on them.
std::string flexible_scene(const std::string& solver) {
  return R"(
bodies:
  - shape: {plane: {normal: [0, 0, 1]}}
  - pile: {count: 20, columns: [3, 3], seed: 3, mix: [{shape: {box: {size: [0.12, 0.1, 0.08]}}}, {shape: {sphere: {radius: 0.06}}}]}
    density: 300
    position: [0, 0, 0.5]
cloths:
  - grid: {size: [1, 1], nodes: [16, 15]}
    mass_per_area: 0.4
    thickness: 0.02
    links: {diagonals: alternating, stiffness: 5000, damping: 0.01}
    area: {stiffness: 3000, damping: 0.005}
    bending: {stiffness: 5}
    position: [0, 0, 0.4]
    pins: [{node: [0, 0]}, {node: [15, 0]}, {node: [0, 14], release: 0.3}]
  - grid: {size: [0.8, 0.8], nodes: [12, 12]}
    mass: 0.3
    thickness: 0.02
    membrane: {youngs_modulus: 1.0e+5, poissons_ratio: 0.3, damping: 0.005}
    bending: {model: dihedral, stiffness: 0.01}
    position: [0.1, 0, 0.3]
threads:
  - points: [[-0.5, 0, 0.9], [0.5, 0.1, 0.9], [0.5, 0.5, 0.9]]
    segments: 40
    radius: 0.01
    mass: 0.1
    bending: {stiffness: 1}
solver: )" +
         solver;
}

// A cloth in the wind, held by a body that turns and one that is fixed, and tied to bodies that are let go at different times,
// one of them far off; a thread that ties two of them.
std::string tied_scene(const std::string& solver) {
  return R"(
wind: [2, 1, 0.5]
bodies:
  - {shape: {plane: {normal: [0, 0, 1]}}}
  - {name: mill, shape: {box: {size: [0.2, 0.1, 0.1]}}, motion: kinematic, position: [-0.6, -0.5, 0.9], angular_velocity: [0, 3, 1]}
  - {name: post, shape: {box: {size: [0.1, 0.1, 0.1]}}, motion: fixed, position: [-0.5, 0.56, 0.8]}
  - {name: crate, shape: {box: {size: [0.12, 0.1, 0.08]}}, mass: 0.3, position: [0.5, -0.5, 0.7]}
  - {name: ball, shape: {sphere: {radius: 0.06}}, mass: 0.4, position: [0.5, 0.5, 0.72]}
  - {name: ballast, shape: {sphere: {radius: 0.1}}, mass: 0.4, position: [0, 4, 2.72]}
  - pile: {count: 10, columns: [2, 2], seed: 3, mix: [{shape: {box: {size: [0.12, 0.1, 0.08]}}}, {shape: {sphere: {radius: 0.06}}}]}
    density: 300
    position: [0, 0, 1]
cloths:
  - grid: {size: [1, 1], nodes: [13, 12]}
    mass_per_area: 0.3
    thickness: 0.02
    drag: 1.3
    pressure: {sine: {mean: 2, amplitude: 5, frequency: 3}}
    links: {stiffness: 3000, damping: 0.01}
    position: [0, 0, 0.8]
    pins: [{node: [0, 0], to: mill}, {node: [0, 11], to: post}, {node: [12, 0], to: crate, release: 0.4}, {node: [12, 11], to: ball},
           {node: [11, 11], to: ball, release: 0.1}, {node: [6, 6], to: ballast}]
threads:
  - points: [[0.5, -0.44, 0.6], [0.5, 0.44, 0.6]]
    segments: 20
    radius: 0.01
    mass: 0.1
    pins: [{node: 0, to: crate}, {node: 20, to: ball}]
solver: )" +
         solver;
}

// Nothing but a cloth, which touches nothing and feels the air.
std::string sail(const std::string& solver) {
  return R"(
wind: [0, 3, 1]
cloths:
  - grid: {size: [1, 1], nodes: [14, 12]}
    mass: 0.3
    thickness: 0.02
    drag: 1.3
    pressure: {sine: {mean: 2, amplitude: 5, frequency: 3}}
    pins: [{node: [0, 0]}, {node: [13, 0], release: 0.2}]
solver: )" +
         solver;
}

void expect_the_states_of_one_rank(const std::string& text) {
  const auto expected = alone(text);
  EXPECT_EQ(together(text, std::nullopt, 0), expected) << "METIS";
  EXPECT_EQ(together(text, std::nullopt, 7), expected) << "METIS, with migration";
  EXPECT_EQ(together(text, 1, 0), expected) << "random";
  EXPECT_EQ(together(text, 2, 13), expected) << "random, with migration";
}

class RanksBitwise : public ::testing::TestWithParam<std::string> {};

TEST_P(RanksBitwise, AnyPartitionGivesTheStatesOfOneRank) { expect_the_states_of_one_rank(mixed_scene(GetParam())); }

INSTANTIATE_TEST_SUITE_P(Ranks, RanksBitwise, ::testing::ValuesIn(solvers));

class RanksBitwiseFlexible : public ::testing::TestWithParam<std::string> {};

TEST_P(RanksBitwiseFlexible, AnyPartitionGivesTheStatesOfOneRank) {
  const std::string text = flexible_scene(GetParam());
  const auto expected = alone(text);
  EXPECT_EQ(together(text, std::nullopt, 7), expected) << "METIS, with migration";
  EXPECT_EQ(together(text, 1, 0), expected) << "random";
}

INSTANTIATE_TEST_SUITE_P(Ranks, RanksBitwiseFlexible,
                         ::testing::Values("{name: accelerated_jacobi, iterations: 12}", "{name: gauss_seidel, iterations: 8}",
                                           "{name: jacobi, iterations: 6, stages: position, warm_start: 0}"));

TEST_P(RanksBitwiseFlexible, TiedBodiesInTheWind) { expect_the_states_of_one_rank(tied_scene(GetParam())); }

TEST_P(RanksBitwiseFlexible, ASailByItself) { expect_the_states_of_one_rank(sail(GetParam())); }

// Controls: the hash sees a change in the last bit of one number, and moves with time.
TEST(RanksBitwiseControl, AChangedSceneDiffers) {
  const std::string text = mixed_scene(solvers[0]);
  std::string changed = text;
  changed.replace(changed.find("velocity: [0, 0, -3]"), 20, "velocity: [0, 0, -3.0000000000000004]");
  const auto a = alone(text), b = alone(changed), c = together(changed, 1, 0);
  for (std::size_t i = 0; i < a.size(); ++i) EXPECT_NE(a[i], b[i]);
  EXPECT_EQ(b, c);
  EXPECT_NE(a[0], a[1]);
  EXPECT_NE(a[1], a[2]);
}

TEST(RanksBitwiseControl, BodiesAreOnAllTheRanksThatWereAskedFor) {
  int size = 0;
  MPI_Comm_size(MPI_COMM_WORLD, &size);
  if (const char* asked = std::getenv("OMPI_COMM_WORLD_SIZE")) {
    EXPECT_EQ(size, std::atoi(asked));
  }
  Experiment run(scene_from_text(mixed_scene(solvers[0])), MPI_COMM_WORLD);
  run.simulation->move_homes(Balance(MPI_COMM_WORLD, 1, false).homes(parts_of(*run.simulation)));
  run.step();
  EXPECT_EQ(run.simulation->halo.size(), size);
  EXPECT_GT(run.world().homes, 150u / static_cast<unsigned>(2 * size));
  EXPECT_LT(run.world().homes, 300u / static_cast<unsigned>(size) + 1);
  EXPECT_EQ(run.world().guests > 0, size > 1);
}

}  // namespace unibody::small_worlds::ranks_bitwise_test
