// The coarse level in whole runs: what it leaves of hanging cloths, and what it does not touch.
#include <gtest/gtest.h>

#include <algorithm>

#include "report/stretch.hpp"
#include "small_worlds.hpp"

namespace unibody::small_worlds::coarse_level_test {

namespace {

// 10 m x 10 m and 10 kg of stiff links, which fall from the horizontal and hang from two corners.
std::string hanging(int nodes, const std::string& more = "") {
  const std::string n = std::to_string(nodes), last = std::to_string(nodes - 1);
  return "  - grid: {size: [10, 10], nodes: [" + n + ", " + n +
         "]}\n    mass: 10\n    thickness: 0.02\n    links: {diagonals: both}\n    position: [0, 0, 10]\n"
         "    pins: [{node: [0, 0]}, {node: [" +
         last + ", 0]}]\n" + more;
}

Scene scene_of(const std::string& text, bool coarse, const std::string& solver = "accelerated_jacobi", int iterations = 50) {
  Scene scene = scene_from_text(text);
  scene.solver.coarse = coarse, scene.solver.name = solver, scene.solver.iterations = iterations;
  return scene;
}

Stretch stretch_of(const Experiment& run) {
  return measure_stretch(MPI_COMM_SELF, run.simulation->world, run.simulation->ties.constraints, 1).at(0);
}

struct Worst {
  double rms = 0, max = 0;
  double rise = -HUGE_VAL;  // J, of the energy in a step
};

Worst worst_of(Experiment& run, int frames, CoarseCounts* counts = nullptr) {
  Worst worst;
  for (int k = 0; k < frames; ++k) {
    const double before = run.energy();
    run.step();
    if (counts != nullptr) counts->add(run.last.coarse);
    const Stretch stretch = stretch_of(run);
    worst.rms = std::max(worst.rms, stretch.rms), worst.max = std::max(worst.max, stretch.max);
    worst.rise = std::max(worst.rise, run.energy() - before);
  }
  return worst;
}

}  // namespace

// The fall until the cloth has swung through, with 50 iterations: RMS stretch below 5e-4 whatever the number of nodes, where
// sweeps alone leave more than ten times that. A stiff cloth in implicit steps can only lose energy.
TEST(CoarseLevel, HangingClothsHardlyStretch) {
  for (const auto& [nodes, frames] : {std::pair{25, 100}, {50, 100}, {80, 40}}) {
    Experiment with(scene_of("cloths:\n" + hanging(nodes), true)), without(scene_of("cloths:\n" + hanging(nodes), false));
    const Worst on = worst_of(with, frames), off = worst_of(without, frames);
    EXPECT_LT(on.rms, 5e-4) << nodes;
    EXPECT_LT(on.max, 1e-2) << nodes;
    EXPECT_GT(off.rms, 10 * on.rms) << nodes;
    EXPECT_LT(on.rise, 0) << nodes;
  }
}

TEST(CoarseLevel, GaussSeidelGoesOnFromIt) {
  Experiment with(scene_of("cloths:\n" + hanging(50), true, "gauss_seidel", 20)),
      without(scene_of("cloths:\n" + hanging(50), false, "gauss_seidel", 20));
  const Worst on = worst_of(with, 50), off = worst_of(without, 50);
  EXPECT_LT(on.rms, 1e-3);
  EXPECT_GT(off.rms, 10 * on.rms);
}

// With more iterations, of which Newton's are a part, all of the error goes, of the rows and of the momenta. Medians, since a few
// frames in which the cloth buckles converge slowly.
TEST(CoarseLevel, MoreIterationsLeaveLess) {
  std::vector<double> rms, residual;
  const auto median = [](std::vector<double> values) {
    std::ranges::nth_element(values, values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2));
    return values[values.size() / 2];
  };
  for (const int iterations : {50, 200, 800}) {
    Experiment run(scene_of("cloths:\n" + hanging(25), true, "accelerated_jacobi", iterations));
    std::vector<double> stretches, residuals;
    for (int k = 0; k < 40; ++k) residuals.push_back(run.step().residual), stretches.push_back(stretch_of(run).rms);
    rms.push_back(median(stretches)), residual.push_back(median(residuals));
  }
  for (std::size_t k = 0; k + 1 < rms.size(); ++k) {
    EXPECT_LT(rms[k + 1], 0.8 * rms[k]) << k;
    EXPECT_LT(residual[k + 1], 0.8 * residual[k]) << k;
  }
}

// A thread that swings down and whips: however far Newton's method comes, what it leaves undone gives no energy.
TEST(CoarseLevel, AWhippingThreadGainsNoEnergy) {
  const std::string rope =
      "threads:\n  - {points: [[0, 0, 2], [1, 0, 2]], segments: 30, mass: 0.1, radius: 0.005, pins: [{node: 0}]}\n";
  for (const int iterations : {25, 50, 100, 200, 400}) {
    Experiment run(scene_of(rope, true, "accelerated_jacobi", iterations));
    CoarseCounts counts;
    const Worst worst = worst_of(run, 200, &counts);
    EXPECT_LT(worst.rise, 0) << iterations;
    EXPECT_EQ(counts.touching, 0) << iterations;
    EXPECT_EQ(counts.all(), 200) << iterations;
    EXPECT_GT(counts.gaining, 0) << iterations;
    EXPECT_GT(counts.solved, 180) << iterations;
    EXPECT_LT(worst.rms, iterations < 100 ? 0.02 : 1e-3) << iterations;
  }
}

// A beam of tetrahedra, clamped at one end, swings down from rest: 50 iterations are within a hundredth of the converged steps,
// of the solver that factorises, where sweeps alone let it sink much further.
TEST(CoarseLevel, ABeamBendsAsTheConvergedOne) {
  const std::string beam =
      "solids:\n  - block: {size: [2, 0.25, 0.25], cells: [16, 2, 2]}\n    density: 1000\n    thickness: 0.01\n"
      "    youngs_modulus: 1.0e8\n    poissons_ratio: 0.3\n"
      "    pins: [{within: {min: [-1.01, -1, -1], max: [-0.99, 1, 1]}}]\n";
  const auto tip = [&](bool coarse, const std::string& solver) {
    Experiment run(scene_of(beam, coarse, solver));
    run.steps(20);
    double lowest = 0;
    for (std::size_t i = 0; i < run.world().homes; ++i) lowest = std::min(lowest, run.world().position[i].z());
    return -0.125 - lowest;
  };
  const double converged = tip(false, "newton");
  EXPECT_GT(converged, 0.01);
  EXPECT_NEAR(tip(true, "accelerated_jacobi"), converged, 0.01 * converged);
  EXPECT_GT(tip(false, "accelerated_jacobi"), 2 * converged);
}

const std::string ground =
    "bodies:\n  - {name: floor, shape: {box: {size: [20, 20, 1]}}, motion: fixed, position: [30, 0, -0.5]}\n";
const std::string lying =
    "  - grid: {size: [2, 2], nodes: [12, 12]}\n    mass: 1\n    thickness: 0.02\n"
    "    links: {diagonals: both}\n    position: [30, 0, 0.01]\n";

// A cloth that touches something takes no part: it moves as it would without a coarse level, to the last bit.
TEST(CoarseLevel, AClothInContactIsSolvedBySweepsAlone) {
  Experiment on(scene_of(ground + "cloths:\n" + lying, true)), off(scene_of(ground + "cloths:\n" + lying, false));
  on.steps(20), off.steps(20);
  EXPECT_NE(on.normal_force(0, 1), 0);
  EXPECT_EQ(on.last.coarse.touching, 1);
  EXPECT_EQ(on.last.coarse.all(), 1);
  EXPECT_EQ(off.last.coarse.all(), 0);
  for (Id id = 1; id <= 144; ++id) EXPECT_EQ(on.position(id), off.position(id)) << id;
}

// Another one, which hangs free, is solved on both levels all the same.
TEST(CoarseLevel, AHangingClothMindsNoOtherInContact) {
  Experiment both(scene_of(ground + "cloths:\n" + lying + hanging(16), true)),
      off(scene_of(ground + "cloths:\n" + lying + hanging(16), false)), alone(scene_of(ground + "cloths:\n" + hanging(16), true));
  both.steps(40), off.steps(40), alone.steps(40);
  EXPECT_EQ(both.last.coarse.touching, 1);
  EXPECT_EQ(both.last.coarse.solved, 1);
  double to_alone = 0, to_off = 0;
  for (Id id = 145; id < 145 + 256; ++id) {
    to_alone = std::max(to_alone, (both.position(id) - alone.position(id - 144)).norm());
    to_off = std::max(to_off, (both.position(id) - off.position(id)).norm());
  }
  EXPECT_LT(to_alone, 0.05 * to_off);
  EXPECT_GT(to_off, 0.01);
}

// Homes on 1 to 4 ranks: the same bits.
TEST(RanksCoarseLevel, StepsHaveTheSameBits) {
  const auto text = "cloths:\n" + hanging(24);
  Experiment alone(scene_of(text, true)), here(scene_of(text, true), MPI_COMM_WORLD);
  for (int k = 0; k < 10; ++k) alone.step(), here.step();
  int compared = 0;
  for (std::size_t i = 0; i < here.world().homes; ++i, ++compared) {
    const Id id = here.world().id[i];
    EXPECT_EQ(here.last.coarse.solved, 1);
    EXPECT_EQ(here.world().position[i], alone.position(id)) << id;
    EXPECT_EQ(here.world().velocity[i], alone.velocity(id)) << id;
  }
  EXPECT_GT(compared, 0);
}

}  // namespace unibody::small_worlds::coarse_level_test
