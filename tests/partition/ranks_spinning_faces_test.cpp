// Faces that spin across ranks: cylinders, boxes, hulls and compounds that slide and turn on a slab and on each other have the
// bits of one rank.
#include <gtest/gtest.h>

#include "small_worlds.hpp"
#include "step/step_parts.hpp"

namespace unibody::small_worlds::ranks_spinning_faces_test {

TEST(RanksSpinningFaces, HaveTheBitsOfOneRank) {
  int ranks = 1;
  MPI_Comm_size(MPI_COMM_WORLD, &ranks);
  for (const char* solver : {"accelerated_jacobi", "gauss_seidel"}) {
    const std::string text = std::string(R"(
materials: {m: {friction: 0.3}}
bodies:
  - {shape: {box: {size: [4, 4, 1]}}, motion: fixed, position: [0, 0, -0.5], material: m}
  - {lattice: {count: 12, columns: [2, 2], spacing: [0.21, 0.21, 0.1], height: 0.05}, shape: {cylinder: {radius: 0.1, length: 0.1}}, mass: 1, velocity: [0.3, 0, 0], angular_velocity: [0, 0, 20], material: m}
  - {lattice: {count: 4, columns: [2, 2], spacing: [0.3, 0.3, 0.1], height: 0.35}, shape: {box: {size: [0.2, 0.15, 0.1]}}, mass: 2, angular_velocity: [0, 0, -15], material: m}
  - {shape: {compound: {parts: [{shape: {box: {size: [0.1, 0.2, 0.02]}}, position: [-0.05, 0, 0]}, {shape: {box: {size: [0.1, 0.2, 0.02]}}, position: [0.05, 0, 0]}]}}, mass: 1, position: [1, 0, 0.01], angular_velocity: [0, 0, 25], material: m}
solver: {iterations: 16, name: )") +
                             solver + "}\n";
    Experiment alone(scene_from_text(text)), run(scene_from_text(text), MPI_COMM_WORLD);
    for (int k = 0; k < 20; ++k) {
      std::vector<int> homes;
      for (std::size_t i = 0; i < run.world().homes; ++i) homes.push_back(static_cast<int>((run.world().id[i] + k / 5) % ranks));
      if (k % 5 == 0) run.simulation->move_homes(homes);
      alone.step(), run.step();
      ASSERT_EQ(run.last.residual, alone.last.residual) << solver << ' ' << k;
      for (std::size_t i = 0; i < run.world().homes; ++i) {
        const BodyState here = run.world().state(i), there = alone.state(run.world().id[i]);
        ASSERT_EQ(here.position, there.position) << solver << ' ' << k << ' ' << run.world().id[i];
        ASSERT_EQ(here.angular_velocity, there.angular_velocity) << solver << ' ' << k << ' ' << run.world().id[i];
      }
    }
  }
}

}  // namespace unibody::small_worlds::ranks_spinning_faces_test
