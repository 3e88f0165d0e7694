// The same bits on any number of ranks, where a contact or a step looks at more than its pair: seams, impacts in order, carriers,
// divided steps and torques that are remembered.
#include <gtest/gtest.h>

#include "partition/balance.hpp"
#include "report/state_hash.hpp"
#include "small_worlds.hpp"
#include "step/step_parts.hpp"

namespace unibody::small_worlds::ranks_contacts_test {

namespace {

struct Case {
  const char* name;
  std::string text;
  bool impacts = false;  // some happen
};
void PrintTo(const Case& c, std::ostream* out) { *out << c.name; }

const Case cases[] = {{"bricks_that_slide_over_bricks", R"(
materials: {m: {friction: 0.1}}
bodies:
  - {shape: {plane: {normal: [0, 0, 1]}}}
  - {shape: {box: {size: [0.5, 0.5, 0.2]}}, mass: 50, lattice: {count: 24, columns: [6, 4], spacing: [0.5, 0.5, 0.2], height: 0.1}}
  - {shape: {box: {size: [0.3, 0.3, 0.1]}}, mass: 1, velocity: [2, 0.7, 0], lattice: {count: 6, columns: [3, 2], spacing: [0.9, 0.8, 1], height: 0.25}}
  - {shape: {sphere: {radius: 0.1}}, mass: 1, velocity: [-1.5, 0.3, 0], lattice: {count: 4, columns: [2, 2], spacing: [1.1, 0.7, 1], height: 0.3}, position: [0.3, 0.4, 0]}
)"},
                      {"elastic_balls_and_boxes", R"(
gravity: [0, 0, -1]
materials: {m: {friction: 0.2, restitution: 0.9}}
bodies:
  - container: {size: [1.2, 1.2]}
  - pile:
      count: 60
      columns: [4, 4]
      seed: 3
      mix:
        - {shape: {sphere: {radius: 0.06}}, scale: [0.5, 1.5]}
        - {shape: {box: {size: [0.12, 0.1, 0.08]}}, scale: [0.5, 1.5]}
    density: 1000
    velocity: [2, 1, -5]
    position: [0, 0, 0.02]
)",
                       true},
                      {"shots", R"(
materials: {m: {friction: 0.2}}
bodies:
  - {shape: {plane: {normal: [0, 0, 1]}}}
  - {shape: {box: {size: [0.1, 0.1, 0.1]}}, mass: 0.2, lattice: {count: 27, columns: [3, 3], spacing: [0.1, 0.1, 0.1], height: 0.05}}
  - {shape: {sphere: {radius: 0.03}}, mass: 0.3, velocity: [-30, 0, 0], lattice: {count: 8, columns: [4, 1], spacing: [0.2, 0.1, 0.07], height: 0.05}, position: [1.2, 0.01, 0.02]}
)"},
                      {"crossing_streams", R"(
gravity: [0, 0, 0]
materials: {m: {friction: 0.2}}
bodies:
  - {shape: {sphere: {radius: 0.03}}, mass: 0.3, velocity: [-20, 0.4, 0], lattice: {count: 24, columns: [8, 3], spacing: [0.7, 0.2, 0.2]}, position: [3, 0, 0]}
  - {shape: {sphere: {radius: 0.03}}, mass: 0.2, velocity: [20, 0, 0.3], lattice: {count: 24, columns: [8, 3], spacing: [0.6, 0.2, 0.2]}, position: [-3, 0.01, 0]}
)",
                       true},
                      {"a_heavy_ball_into_small_ones", R"(
materials: {m: {friction: 0.2}}
bodies:
  - {shape: {plane: {normal: [0, 0, 1]}}}
  - {shape: {sphere: {radius: 0.2}}, mass: 40, velocity: [-4, 0.3, 0], position: [1.1, 0, 0.2]}
  - {shape: {sphere: {radius: 0.02}}, mass: 0.04, lattice: {count: 120, columns: [8, 5], spacing: [0.06, 0.06, 0.06], height: 0.02}}
  - {shape: {box: {size: [0.05, 0.04, 0.03]}}, mass: 0.1, lattice: {count: 40, columns: [4, 5], spacing: [0.07, 0.07, 0.05], height: 0.02}, position: [-0.6, 0, 0]}
)"},
                      {"on_a_carousel", R"(
materials: {m: {friction: 0.6, rolling_friction: 0.01}}
bodies:
  - {shape: {cylinder: {radius: 3, length: 0.1}}, motion: kinematic, position: [0, 0, -0.05], angular_velocity: [0, 0, 1.5]}
  - {shape: {box: {size: [0.2, 0.2, 0.2]}}, mass: 1, lattice: {count: 32, columns: [4, 4], spacing: [0.4, 0.4, 0.2], height: 0.1}}
  - {shape: {sphere: {radius: 0.1}}, mass: 1, lattice: {count: 16, columns: [4, 4], spacing: [0.4, 0.4, 0.2], height: 0.5}}
)"},
                      {"whirling_chains", R"(
bodies:
  - {shape: {plane: {normal: [0, 0, 1]}}, position: [0, 0, -1]}
  - {name: a, shape: {box: {size: [0.3, 0.1, 0.1]}}, mass: 1, position: [0.15, 0, 0], angular_velocity: [0, 0, 60], velocity: [0, 9, 0]}
  - {name: b, shape: {box: {size: [0.3, 0.1, 0.1]}}, mass: 1, position: [0.45, 0, 0], angular_velocity: [0, 0, 60], velocity: [0, 27, 0]}
  - {shape: {box: {size: [0.2, 0.2, 0.2]}}, mass: 1, lattice: {count: 12, columns: [3, 2], spacing: [0.5, 0.5, 0.2], height: 0.1}, position: [2, 0, -1]}
joints:
  - {type: ball, bodies: [a, world], anchor: [0, 0, 0]}
  - {type: hinge, bodies: [a, b], anchor: [0.3, 0, 0], axis: [0, 0, 1]}
)"}};

const char* const solvers[] = {"accelerated_jacobi", "gauss_seidel"};

}  // namespace

class RanksContacts : public testing::TestWithParam<std::tuple<Case, const char*>> {};

TEST_P(RanksContacts, SameBits) {
  const auto& [c, solver] = GetParam();
  const std::string text = "solver: {iterations: 12, name: " + std::string(solver) + "}\n" + c.text;
  Experiment alone(scene_from_text(text)), together(scene_from_text(text), MPI_COMM_WORLD);
  const auto deal = [&](std::uint64_t seed) {
    together.simulation->detect();
    together.simulation->move_homes(Balance(MPI_COMM_WORLD, seed, true).homes(parts_of(*together.simulation)));
  };
  together.simulation->move_homes(Balance(MPI_COMM_WORLD, 17, true).homes(parts_of(*together.simulation)));
  std::int64_t impacts = 0;
  for (int k = 1; k <= 40; ++k) {
    alone.step();
    if (k % 7 == 0) deal(static_cast<std::uint64_t>(k));
    together.step();
    EXPECT_EQ(alone.last.impacts, together.last.impacts) << k;
    impacts += alone.last.impacts;
    ASSERT_EQ(state_hash(MPI_COMM_WORLD, together.world()), state_hash(MPI_COMM_SELF, alone.world())) << "step " << k;
  }
  EXPECT_EQ(impacts > 0, c.impacts);
}

INSTANTIATE_TEST_SUITE_P(All, RanksContacts, testing::Combine(testing::ValuesIn(cases), testing::ValuesIn(solvers)));

}  // namespace unibody::small_worlds::ranks_contacts_test
