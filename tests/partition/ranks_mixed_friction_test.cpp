// Contacts with friction and contacts without it stand beside each other in the solver's memory: which of them depends on the
// rank, and the bits must not.
#include <gtest/gtest.h>

#include "small_worlds.hpp"

namespace unibody::small_worlds::ranks_mixed_friction_test {

namespace {

std::vector<int> mixed_homes(const World& world, int turn) {
  int ranks = 1;
  MPI_Comm_size(MPI_COMM_WORLD, &ranks);
  std::vector<int> homes;
  for (std::size_t i = 0; i < world.homes; ++i) homes.push_back(static_cast<int>((world.id[i] + turn) / 3 % ranks));
  return homes;
}

// Boxes, cylinders and balls of two materials, one of them without friction, on ground of the one with friction.
std::string heap(const std::string& ground, const char* solver) {
  std::string text =
      "materials: {smooth: {friction: 0}, rough: {friction: 0.5}}\nsolver: {iterations: 12, name: " + std::string(solver) +
      "}\nbodies:\n  - {material: rough, " + ground + "}\n";
  const char* shapes[] = {"box: {size: [0.2, 0.14, 0.1]}", "cylinder: {radius: 0.06, length: 0.16}", "sphere: {radius: 0.08}",
                          "box: {size: [0.12, 0.12, 0.12]}"};
  for (int k = 0; k < 48; ++k)
    text += "  - {shape: {" + std::string(shapes[k % 4]) + "}, mass: 1, material: " + (k * 7 % 5 < 2 ? "smooth" : "rough") +
            ", position: [" + std::to_string(-0.4 + 0.21 * (k % 4) + 0.013 * (k % 7)) + ", " +
            std::to_string(-0.4 + 0.21 * (k / 4 % 4) + 0.011 * (k % 5)) + ", " + std::to_string(0.12 + 0.22 * (k / 16)) +
            "], velocity: [" + std::to_string(0.3 * (k % 3 - 1)) + ", 0, -0.5], angular_velocity: [0.5, " +
            std::to_string(k % 4) + ", -1]}\n";
  return text;
}

}  // namespace

TEST(RanksMixedFriction, AHeapHasTheBitsOfOneRank) {
  const std::string grounds[] = {
      "shape: {plane: {normal: [0, 0, 1]}}",
      "shape: {cylinder: {radius: 2, length: 0.2}}, position: [0, 0, -0.1], motion: kinematic, angular_velocity: [0, 0, 2]"};
  for (const std::string& ground : grounds)
    for (const char* solver : {"accelerated_jacobi", "jacobi", "gauss_seidel"}) {
      const std::string text = heap(ground, solver);
      Experiment alone(scene_from_text(text)), run(scene_from_text(text), MPI_COMM_WORLD);
      int differ = 0;
      for (int k = 0; k < 40; ++k) {
        if (k % 10 == 1) run.simulation->move_homes(mixed_homes(run.world(), k));
        alone.step(), run.step();
        const World& w = run.world();
        for (std::size_t i = 0; i < w.homes; ++i) differ += w.state(i).position != alone.state(w.id[i]).position;
      }
      EXPECT_EQ(differ, 0) << solver << ", " << ground;
    }
}

}  // namespace unibody::small_worlds::ranks_mixed_friction_test
