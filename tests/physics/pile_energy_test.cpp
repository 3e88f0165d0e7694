// What a solve of few iterations leaves undone in a deep pile may only take energy away.
#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "small_worlds.hpp"

namespace unibody::small_worlds::pile_energy_test {

namespace {

constexpr double diameter = 0.1;  // m

// Columns of balls of 1 kg at rest, touching: 4 by 4 of so many, between smooth walls.
std::string pile(int layers, const std::string& solver, const std::string& more) {
  const std::string d = std::to_string(diameter), width = std::to_string(4 * diameter);
  return "solver: {" + solver + "}\n" + more +
         "materials: {ball: {friction: 0.5}, wall: {friction: 0}}\n"
         "bodies:\n"
         "  - {shape: {plane: {normal: [0, 0, 1]}}, material: ball}\n"
         "  - lattice: {count: " +
         std::to_string(16 * layers) + ", columns: [4, 4], spacing: [" + d + ", " + d + ", " + d + "], height: 0.05}\n" +
         "    name: ball\n    shape: {sphere: {radius: 0.05}}\n    mass: 1\n    material: ball\n" + "  - {container: {size: [" +
         width + ", " + width + "]}, material: wall}\n";
}

// More of a scene's text, for piles of so many layers: a joint that ties two balls of the top layer together, and a cloth that
// lies on the top layer.
std::string joint_at_the_top(int layers) {
  const int last = 16 * layers - 1;
  return "joints: [{type: ball, bodies: ['ball[" + std::to_string(last) + "]', 'ball[" + std::to_string(last - 1) +
         "]'], anchors: [[-0.05, 0, 0], [0.05, 0, 0]]}]\n";
}
std::string cloth_at_the_top(int layers) {
  return "cloths: [{name: sheet, grid: {size: [0.32, 0.32], nodes: [5, 5]}, links: {}, position: [0, 0, " +
         std::to_string(diameter * layers + 0.003) + "], mass: 0.05, thickness: 0.005, material: ball}]\n";
}
std::string nothing(int) { return ""; }

}  // namespace

struct PileCase {
  int layers, frames;
  const char* solver;
  std::string (*more)(int layers) = nothing;
};

class PileEnergy : public testing::TestWithParam<PileCase> {};

// The energy never passes that of the start. The test allows for one thing: every contact may end open by 1e-4 of a diameter. The
// layers of a pile then stand so far apart, and each layer is higher by that length times the number of layers below it.
TEST_P(PileEnergy, NeverPassesThatOfTheStart) {
  const PileCase c = GetParam();
  Experiment run(scene_from_text(pile(c.layers, c.solver, c.more(c.layers))));
  const double start = run.energy(), balls = 16.0 * c.layers, lift = 1e-4 * diameter * 0.5 * (c.layers + 1);
  double most = start;
  for (int k = 0; k < c.frames; ++k) {
    run.step();
    most = std::max(most, run.energy());
  }
  EXPECT_LE(most, start + balls * 9.81 * lift) << c.layers << " layers, " << c.solver;
}

INSTANTIATE_TEST_SUITE_P(
    Piles, PileEnergy,
    testing::Values(
        PileCase{10, 300, "iterations: 50"}, PileCase{20, 300, "iterations: 20"}, PileCase{20, 300, "iterations: 50"},
        PileCase{20, 300, "iterations: 50, velocity_share: 0.5"}, PileCase{50, 300, "iterations: 25"},
        PileCase{50, 300, "iterations: 50"}, PileCase{100, 300, "iterations: 10"}, PileCase{100, 300, "iterations: 50"},
        PileCase{100, 300, "iterations: 50, velocity_share: 0.5"}, PileCase{100, 200, "iterations: 100"},
        PileCase{50, 300, "iterations: 50, stages: together"}, PileCase{10, 300, "iterations: 10, name: gauss_seidel"},
        PileCase{20, 300, "iterations: 5, name: gauss_seidel"}, PileCase{20, 300, "iterations: 20, name: gauss_seidel"},
        PileCase{20, 300, "iterations: 20, name: gauss_seidel, friction: cone"},
        PileCase{20, 300, "iterations: 29, name: gauss_seidel, friction: none"},
        PileCase{50, 300, "iterations: 25, name: gauss_seidel"}, PileCase{20, 300, "iterations: 50, name: gauss_seidel"},
        PileCase{50, 300, "iterations: 100, name: gauss_seidel, acceleration: none"},
        PileCase{20, 300, "iterations: 20, name: gauss_seidel, stages: together"},
        PileCase{50, 300, "iterations: 50, name: gauss_seidel"},
        PileCase{50, 300, "iterations: 50, name: gauss_seidel", joint_at_the_top},
        PileCase{50, 300, "iterations: 50, name: gauss_seidel", cloth_at_the_top},
        PileCase{50, 300, "iterations: 200, name: gauss_seidel"}, PileCase{100, 300, "iterations: 50, name: gauss_seidel"}));

}  // namespace unibody::small_worlds::pile_energy_test
