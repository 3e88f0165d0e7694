// A pile of boxes that has fallen comes to rest: its columns do not go on rocking on what their steps leave unsolved.
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <utility>

#include "small_worlds.hpp"

namespace unibody::small_worlds::columns_rest_test {

namespace {

constexpr double boxes = 200, width = 0.12;  // m; 1 kg each

// Columns of eight boxes, a third of a width apart, dropped by a few centimetres and slightly turned.
std::string columns(const std::string& solver, int seed = 0) {
  return "solver: {" + solver +
         "}\n"
         "bodies:\n"
         "  - {shape: {plane: {normal: [0, 0, 1]}}}\n"
         "  - lattice: {count: 200, columns: [5, 5], spacing: [0.16, 0.16, 0.19], height: 0.2, jitter: 0.01, "
         "rotation_jitter: 0.05, seed: " +
         std::to_string(seed) +
         "}\n"
         "    shape: {box: {size: [0.12, 0.12, 0.15]}}\n    mass: 1\n"
         "  - {container: {size: [0.9, 0.9]}}\n";
}

const char* const far_cloth =
    "cloths:\n"
    "  - {grid: {size: [0.4, 0.4], nodes: [5, 5]}, mass: 0.001, thickness: 0.01, position: [0, 0, 100], "
    "pins: [{node: [0, 0]}, {node: [4, 0]}, {node: [0, 4]}, {node: [4, 4]}]}\n";

// m, of the bodies above 50 m
double lowest(Experiment& run) {
  double least = 1000;
  for (std::size_t i = 0; i < run.world().homes; ++i)
    if (const double z = run.world().position[i].z(); z > 50) least = std::min(least, z);
  return least;
}

}  // namespace

struct ColumnsCase {
  const char* solver;
  bool with_cloth;
  int piles = 1;  // that start a little differently
};

class ColumnsOfBoxes : public testing::TestWithParam<ColumnsCase> {};

namespace {

// J, of the boxes: the kinetic energy, and the whole.
std::pair<double, double> energy_of_boxes(Experiment& run) {
  double kinetic = 0, potential = 0;
  for (int k = 1; k <= static_cast<int>(boxes); ++k) {
    const BodyState box = run.state(k);
    const Vec3 inertia = run.world().properties[run.slot(k)].inertia;
    const Vec3 spin = box.orientation.conjugate() * box.angular_velocity;
    kinetic += 0.5 * (box.velocity.squaredNorm() + inertia.dot(spin.cwiseProduct(spin)));
    potential += 9.81 * box.position.z();
  }
  return {kinetic, kinetic + potential};
}

}  // namespace

// At rest the kinetic energy is 0. A box that is lifted by a ten-thousandth of its width has 0.12 mJ more; the bound is that of
// all boxes, 0.024 J, where columns that go on rocking have about 1 J. Nor may piles gain energy, on the mean, once what the
// landing pressed together has come out. (Fifty iterations do not solve their steps: one pile gains or loses up to 0.1 J in
// some seconds, with the columns that happen to lean.) A cloth of 1 g that hangs far above changes nothing of that.
TEST_P(ColumnsOfBoxes, ComeToRest) {
  const auto [solver, with_cloth, piles] = GetParam();
  const double least = boxes * 9.81 * 1e-4 * width;
  double gain = 0;  // J
  for (int seed = 0; seed < piles; ++seed) {
    Experiment run(scene_from_text(columns(solver, seed) + (with_cloth ? far_cloth : "")));
    run.steps(300);
    const auto [kinetic, landed] = energy_of_boxes(run);
    EXPECT_LT(kinetic, least) << seed;
    run.steps(300);
    gain += (energy_of_boxes(run).second - landed) / piles;
  }
  EXPECT_LT(gain, least);
}

INSTANTIATE_TEST_SUITE_P(Solvers, ColumnsOfBoxes,
                         testing::Values(ColumnsCase{"iterations: 50", false, 4}, ColumnsCase{"iterations: 100", false},
                                         ColumnsCase{"iterations: 200", false},
                                         ColumnsCase{"iterations: 50, name: gauss_seidel", false, 4},
                                         ColumnsCase{"iterations: 100, name: gauss_seidel", false},
                                         ColumnsCase{"iterations: 200, name: gauss_seidel", false},
                                         ColumnsCase{"iterations: 50", true, 4},
                                         ColumnsCase{"iterations: 50, name: gauss_seidel", true, 4}));

// And the other way round: a cloth hangs as it does alone, although boxes far below it are far from solved. What it lacks to its
// right sag of 1 mm is what these iterations leave undone. With accelerated_jacobi it hangs a twentieth lower than alone; the
// cause is not known.
TEST(ColumnsOfBoxes, LeaveAFarClothAsItIs) {
  for (const auto& [solver, allowed] : {std::pair("name: accelerated_jacobi", 0.1), std::pair("name: gauss_seidel", 1e-3)}) {
    Experiment alone(scene_from_text("solver: {" + std::string(solver) + "}\n" + far_cloth));
    Experiment together(scene_from_text(columns(solver) + far_cloth));
    alone.steps(100), together.steps(100);
    const double sag = 100 - lowest(alone), sag_together = 100 - lowest(together);
    EXPECT_GT(sag, 0.5e-3) << solver;
    EXPECT_NEAR(sag_together, sag, allowed * sag) << solver;
  }
}

}  // namespace unibody::small_worlds::columns_rest_test
