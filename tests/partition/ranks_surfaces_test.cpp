// The same bits on any number of ranks, for contacts of surfaces: their faces lie across ranks, and so do those around them.
#include <gtest/gtest.h>

#include "partition/balance.hpp"
#include "report/state_hash.hpp"
#include "report/surface_report.hpp"
#include "small_worlds.hpp"
#include "step/step_parts.hpp"

namespace unibody::small_worlds::ranks_surfaces_test {

namespace {

struct Case {
  const char* name;
  std::string text;  // without the solver
  int steps;
};
void PrintTo(const Case& c, std::ostream* out) { *out << c.name; }

const std::vector<Case> cases{{"bodies_on_a_cloth", R"(
bodies:
  - pile: {count: 14, columns: [3, 3], seed: 3, mix: [{shape: {box: {size: [0.12, 0.1, 0.08]}}}, {shape: {sphere: {radius: 0.05}}}]}
    density: 300
    velocity: [0.3, 0, -2]
    position: [0, 0, 0.02]
cloths:
  - grid: {size: [1, 1], nodes: [8, 7]}
    mass: 0.6
    thickness: 0.01
    links: {stiffness: 5000, damping: 0.01}
    pins: [{node: [0, 0]}, {node: [7, 0]}, {node: [0, 6]}, {node: [7, 6], release: 0.2}]
)",
                               30},
                              // Each between nodes that are far from it: only their faces tell their ranks of each other.
                              {"grains_on_wide_faces", R"(
bodies:
  - lattice: {count: 25, columns: [5, 5], spacing: [1.3, 1.2, 1], height: 0.08, jitter: 0.01}
    shape: {sphere: {radius: 0.05}}
    mass: 0.1
cloths:
  - {grid: {size: [8, 8], nodes: [5, 5]}, mass: 1, thickness: 0.01, velocity: [0, 0, 0.3]}
)",
                               15},
                              {"a_bullet", R"(
bodies:
  - {shape: {sphere: {radius: 0.05}}, mass: 0.2, position: [0.03, 0.02, 0.9], velocity: [0, 10, -150]}
  - {shape: {box: {size: [0.1, 0.1, 0.1]}}, mass: 0.2, position: [0.3, -0.2, -1.4], velocity: [0, 20, 100]}
cloths:
  - {grid: {size: [1, 1], nodes: [4, 4]}, mass: 1, thickness: 0.01, links: {stiffness: 5000, damping: 0.01}}
)",
                               12},
                              {"solids_in_a_heap", R"(
bodies:
  - {shape: {plane: {normal: [0, 0, 1]}}}
  - {shape: {box: {size: [0.2, 0.2, 0.2]}}, mass: 3, position: [0.05, 0, 0.12]}
solids:
  - block: {size: [0.6, 0.5, 0.2], cells: [3, 2, 1]}
    position: [0, 0, 0.4]
    velocity: [0, 0, -3]
    density: 300
    youngs_modulus: 5.0e+4
    poissons_ratio: 0.4
    thickness: 0.01
    least_volume: 0.1
    pressure: [[0, 0], [0.2, -400]]
    loads: [{within: {min: [0.3, -1, 0], max: [0.3, 1, 1]}, force: [{sine: {amplitude: 30, frequency: 4}}, 0, 5]}]
  - block: {size: [0.3, 0.3, 0.3], cells: [1, 2, 1]}
    position: [0.1, 0.1, 0.75]
    orientation: {axis: [0, 1, 0], angle: 12}
    velocity: [0, 0, -5]
    angular_velocity: [3, 0, 0]
    density: 300
    youngs_modulus: 2.0e+4
    poissons_ratio: 0.3
    damping: 0.01
    thickness: 0.01
    self_collision: true
cloths:
  - grid: {size: [0.5, 0.5], nodes: [6, 6]}
    mass: 0.3
    thickness: 0.01
    position: [0, 0, 0.53]
)",
                               30},
                              {"a_cloth_that_folds", R"(
bodies:
  - {shape: {plane: {normal: [0, 0, 1]}}}
cloths:
  - grid: {size: [1, 0.5], nodes: [14, 7]}
    mass: 0.2
    thickness: 0.02
    self_collision: true
    orientation: {axis: [0, 1, 0], angle: 80}
    position: [0.01, 0, 0.52]
    velocity: [0, 0.1, -3]
)",
                               40},
                              {"on_a_mesh_of_spikes", R"(
bodies:
  - shape: {mesh: {height_field: {size: [2, 2], cells: [4, 4], heights: [0, 0.1, 0, 0, 0, 0, 0.6, 0, 0.5, 0, 0, 0, 0.1, 0, 0, 0, 0.5, 0, 0.4, 0, 0, 0, 0, 0, 0]}}}
cloths:
  - grid: {size: [1.8, 1.8], nodes: [6, 5]}
    mass: 0.4
    thickness: 0.02
    position: [0.03, 0.02, 0.66]
    velocity: [0, 0, -1]
threads:
  - {points: [[-0.9, 0.1, 0.75], [0.9, 0.2, 0.75]], segments: 6, radius: 0.01, mass: 0.1, velocity: [0, 0, -6]}
solids:
  - block: {size: [0.6, 0.6, 0.3], cells: [1, 1, 1]}
    position: [-0.3, 0.4, 1.1]
    velocity: [0, 0, -5]
    density: 200
    youngs_modulus: 5.0e+4
    poissons_ratio: 0.3
    thickness: 0.02
)",
                               12},
                              {"two_cloths", R"(
bodies:
  - {shape: {sphere: {radius: 0.2}}, mass: 5, position: [0, 0, -0.3]}
cloths:
  - grid: {size: [1, 1], nodes: [7, 6]}
    mass: 0.4
    thickness: 0.02
    membrane: {youngs_modulus: 1.0e+5, poissons_ratio: 0.3, damping: 0.005}
    pins: [{node: [0, 0]}, {node: [6, 0]}, {node: [6, 5]}]
  - grid: {size: [0.7, 0.7], nodes: [6, 6]}
    mass: 0.3
    thickness: 0.02
    self_collision: true
    orientation: {axis: [0.6, 0, 0.8], angle: 25}
    position: [0.03, 0, 0.25]
    velocity: [0, 0, -4]
)",
                               30},
                              {"threads_across_a_ball", R"(
bodies:
  - {shape: {sphere: {radius: 0.15}}, mass: 3, position: [0.02, 0, 0]}
  - {shape: {box: {size: [0.1, 0.1, 0.1]}}, mass: 0.2, position: [0.02, 0, 0.3]}
threads:
  - {points: [[-0.5, 0.1, 0.18], [0.5, 0.05, 0.18]], segments: 11, radius: 0.01, mass: 0.1, self_collision: true}
  - {points: [[0.1, -0.5, 0.21], [0, 0.5, 0.21]], segments: 9, radius: 0.01, mass: 0.1, velocity: [0, 0, -2]}
gravity: [0, 1, -9.81]
)",
                               30}};

const std::string solvers[] = {"{name: accelerated_jacobi, iterations: 14}", "{name: gauss_seidel, iterations: 40}"};

// After every fifth step: the state, what was held, and crossings; and whether there were contacts of surfaces at all.
struct Story {
  std::vector<std::uint64_t> hashes;
  std::vector<std::int64_t> counts;
  bool touched = false;
  bool operator==(const Story& other) const { return hashes == other.hashes && counts == other.counts; }
};
void PrintTo(const Story& story, std::ostream* out) {
  for (const auto h : story.hashes) *out << h << ' ';
  for (const auto c : story.counts) *out << c << ' ';
}

template <class Between>
Story told(Experiment& run, MPI_Comm comm, int steps, Between between) {
  Story story;
  for (int k = 1; k <= steps; ++k) {
    run.step();
    story.counts.push_back(run.last.guard.pairs), story.counts.push_back(run.last.sliding);
    between(k);
    run.simulation->detect();
    std::int64_t contacts = 0;
    for (const SurfaceContact& c : run.simulation->contacts.surface) contacts += counts_here(run.world(), c);
    MPI_Allreduce(MPI_IN_PLACE, &contacts, 1, MPI_INT64_T, MPI_SUM, comm);
    story.touched |= contacts > 0;
    if (k % 5 != 0) continue;
    story.counts.push_back(contacts);
    story.counts.push_back(count_crossings(comm, run.world(), run.simulation->search.surfaces));
    story.hashes.push_back(state_hash(comm, run.world()));
  }
  return story;
}

Story alone(const std::string& text, int steps) {
  Experiment run(scene_from_text(text));
  return told(run, MPI_COMM_SELF, steps, [](int) {});
}

Story together(const std::string& text, int steps, std::optional<std::uint64_t> seed, int migrate_every) {
  Experiment run(scene_from_text(text), MPI_COMM_WORLD);
  Simulation& s = *run.simulation;
  const auto move = [&](std::uint64_t k) {
    s.move_homes(Balance(MPI_COMM_WORLD, seed ? std::optional(*seed + k) : std::nullopt, true).homes(parts_of(s)));
  };
  move(0);
  return told(run, MPI_COMM_WORLD, steps, [&](int k) {
    if (migrate_every > 0 && k % migrate_every == 0) s.detect(), move(static_cast<std::uint64_t>(k));
  });
}

class RanksSurfaces : public ::testing::TestWithParam<std::tuple<Case, std::string>> {};

}  // namespace

TEST_P(RanksSurfaces, AnyPartitionGivesTheStatesOfOneRank) {
  const auto& [scene, solver] = GetParam();
  const std::string text = scene.text + "solver: " + solver + "\n";
  const Story expected = alone(text, scene.steps);
  EXPECT_TRUE(expected.touched) << "such a run tells nothing";
  EXPECT_EQ(together(text, scene.steps, std::nullopt, 0), expected) << "METIS";
  EXPECT_EQ(together(text, scene.steps, 1, 0), expected) << "random";
  EXPECT_EQ(together(text, scene.steps, 2, 7), expected) << "random, with migration";
}

INSTANTIATE_TEST_SUITE_P(Ranks, RanksSurfaces, ::testing::Combine(::testing::ValuesIn(cases), ::testing::ValuesIn(solvers)),
                         [](const auto& param_of) {
                           return std::string(std::get<0>(param_of.param).name) +
                                  (param_of.index % 2 ? "_gauss_seidel" : "_jacobi");
                         });

}  // namespace unibody::small_worlds::ranks_surfaces_test
