// Probes against bodies whose ways are known, and the same bits on any number of ranks.
#include "report/probes.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "partition/balance.hpp"
#include "scene/scene_text.hpp"
#include "small_worlds.hpp"
#include "step/step_parts.hpp"

namespace unibody::small_worlds::probes_test {
namespace {

using Row = std::map<std::string, double>;

Row take_frame(Experiment& run, MPI_Comm comm, int steps = 1) {
  Probes probes(run.scene->probes, steps * run.h(), run.scene->period);
  probes.start_frame(run.world());
  run.steps(steps);
  Row row;
  for (const NamedValue& column : probes.columns(comm, run.world()))
    if (column.known) row[column.name] = column.value;
  return row;
}

// Balls of 1 kg fly along x at 1 m/s from x = -0.15, -0.25 ..., in frames of 0.1 s: one passes x = 0 in each frame from the
// second on. Another of 4 kg comes back at 2 m/s; one passes beside the disc.
TEST(Probes, AFlowIsCountedBothWays) {
  Experiment run(scene_from_text(
      "gravity: [0, 0, 0]\ntime: {frame: 0.1, substeps: 1}\nbodies:\n"
      "  - {name: train, points: [[-0.15, 0, 0], [-0.25, 0, 0], [-0.35, 0, 0]], shape: {sphere: {radius: 0.01}}, mass: 1, "
      "velocity: "
      "[1, 0, 0]}\n"
      "  - {name: back, shape: {sphere: {radius: 0.01}}, mass: 4, position: [0.5, 0.1, 0], velocity: [-2, 0, 0]}\n"
      "  - {name: beside, shape: {sphere: {radius: 0.01}}, mass: 8, position: [-0.05, 0.6, 0], velocity: [1, 0, 0]}\n"
      "probes:\n"
      "  - {name: gate, flow: {point: [0, 0, 0], normal: [1, 0, 0], radius: 0.5}}\n"
      "  - {name: trains, of: train, flow: {point: [0, 0, 0], normal: [-1, 0, 0]}}\n"));
  const double counts[] = {0, 1, 0, 1, 0};  // of the gate: the train, and at 0.25 s the one that comes back
  const double masses[] = {0, 1, -3, 1, 0}, momenta[] = {0, 1, 1 + 8, 1, 0};
  for (int k = 0; k < 5; ++k) {
    Row row = take_frame(run, MPI_COMM_SELF);
    EXPECT_EQ(row.at("gate_count (1)"), counts[k]) << k;
    EXPECT_EQ(row.at("gate_mass (kg)"), masses[k]) << k;
    EXPECT_NEAR(row.at("gate_momentum (kg m/s)"), momenta[k], 1e-12) << k;
    EXPECT_EQ(row.at("trains_count (1)"), k >= 1 && k <= 3 ? -1 : 0) << k;
  }
}

// A ball passes the images of a disc in a cell of 0.25 m: one in each frame in which it goes 0.25 m, and four in one of a metre.
TEST(Probes, ImagesOfPeriodicScenesCount) {
  const std::string text =
      "gravity: [0, 0, 0]\ntime: {frame: 0.125, substeps: 2}\nperiodic: {x: [0, 0.25]}\nbodies:\n"
      "  - {shape: {sphere: {radius: 0.01}}, mass: 2, position: [0.2, 0.5, 0], velocity: [0.5, 0, 0]}\n"
      "probes:\n"
      "  - {name: all, flow: {point: [0.25, 0, 0], normal: [1, 0, 0]}}\n"
      "  - {name: near, flow: {point: [0.25, 0.5, 0], normal: [1, 0, 0], radius: 0.1}}\n"
      "  - {name: beside, flow: {point: [0.25, 0, 0], normal: [1, 0, 0], radius: 0.1}}\n"
      "  - {name: across, flow: {point: [0, 0.6, 0], normal: [0, 1, 0]}}\n"
      "  - {name: border, box: {low: [0.2, 0, -1], high: [0.3, 1, 1]}}\n";
  Experiment run(scene_from_text(text)), far(scene_from_text(text));
  for (int k = 0; k < 8; ++k) {
    const double from = 0.2 + 0.0625 * k, to = from + 0.0625;
    const double passed = std::floor(to / 0.25) - std::floor(from / 0.25);
    Row row = take_frame(run, MPI_COMM_SELF, 2);
    EXPECT_EQ(row.at("all_count (1)"), passed) << k;
    EXPECT_EQ(row.at("near_mass (kg)"), 2 * passed) << k;
    EXPECT_EQ(row.at("beside_count (1)") + row.at("across_count (1)"), 0) << k;
    const double place = to - 0.25 * std::floor(to / 0.25);
    EXPECT_EQ(row.at("border_count (1)"), place >= 0.2 || place < 0.05) << k;
  }
  Row row = take_frame(far, MPI_COMM_SELF, 32);
  EXPECT_EQ(row.at("all_count (1)"), 4);
  EXPECT_EQ(row.at("near_mass (kg)"), 8);
}

TEST(Probes, ABoxCountsWhatIsInIt) {
  Experiment run(scene_from_text(
      "gravity: [0, 0, 0]\ntime: {frame: 0.1}\nmaterials: {red: {friction: 0}, blue: {friction: 0}}\nbodies:\n"
      "  - {shape: {sphere: {radius: 0.01}}, mass: 1, position: [0.5, 0.5, 0.5], velocity: [1, 0, 0], material: red}\n"
      "  - {shape: {sphere: {radius: 0.01}}, mass: 3, position: [0.2, 0.5, 0.5], velocity: [0, -1, 2], material: blue}\n"
      "  - {shape: {box: {size: [0.1, 0.1, 0.1]}}, motion: fixed, position: [0.7, 0.7, 0.7]}\n"
      "probes:\n"
      "  - {name: all, box: {low: [0, 0, 0], high: [1, 1, 1]}}\n"
      "  - {name: blue, material: blue, box: {low: [0, 0, 0], high: [1, 1, 1]}}\n"
      "  - {name: far, box: {low: [5, 5, 5], high: [6, 6, 6]}}\n"));
  Row row = take_frame(run, MPI_COMM_SELF);
  EXPECT_EQ(row.at("all_count (1)"), 2);
  EXPECT_EQ(row.at("all_mass (kg)"), 4);
  EXPECT_NEAR(row.at("all_velocity_x (m/s)"), 0.25, 1e-12);
  EXPECT_NEAR(row.at("all_velocity_y (m/s)"), -0.75, 1e-12);
  EXPECT_NEAR(row.at("all_velocity_z (m/s)"), 1.5, 1e-12);
  EXPECT_EQ(row.at("blue_count (1)"), 1);
  EXPECT_EQ(row.at("blue_mass (kg)"), 3);
  EXPECT_EQ(row.at("far_count (1)"), 0);
  EXPECT_FALSE(row.contains("far_velocity_x (m/s)"));  // of nothing
  for (int k = 0; k < 5; ++k) row = take_frame(run, MPI_COMM_SELF);
  EXPECT_EQ(row.at("all_count (1)"), 0);  // the first has left at 0.5 s, the second at 0.25 s
}

// What flows into a box is what is in it more than before.
TEST(RanksProbes, AreTheSameAndLoseNothing) {
  const std::string text =
      "time: {frame: 0.02, substeps: 2}\nsolver: {iterations: 10}\nbodies:\n  - container: {size: [0.6, 0.6]}\n"
      "  - {name: bead, pile: {count: 120, columns: [4, 4], mix: [{shape: {sphere: {radius: 0.04}}, scale: [0.6, 1.3]}]}, "
      "density: "
      "2000, position: [0, 0, 0.4]}\n"
      "probes:\n  - {name: down, flow: {point: [0, 0, 0.3], normal: [0, 0, -1]}}\n"
      "  - {name: low, box: {low: [-9, -9, -9], high: [9, 9, 0.3]}}\n";
  Experiment alone(scene_from_text(text)), run(scene_from_text(text), MPI_COMM_WORLD);
  const Balance balance(MPI_COMM_WORLD, 3, true);
  run.simulation->move_homes(balance.homes(parts_of(*run.simulation)));
  double passed = 0;
  for (int k = 0; k < 40; ++k) {
    const Row one = take_frame(alone, MPI_COMM_SELF, 2), all = take_frame(run, MPI_COMM_WORLD, 2);
    ASSERT_EQ(one, all) << k;
    passed += one.at("down_count (1)");
    ASSERT_EQ(passed, one.at("low_count (1)")) << k;
  }
  EXPECT_GT(passed, 40);
}

struct Fault {
  const char* name;
  std::string text, message;
};
void PrintTo(const Fault& fault, std::ostream* out) { *out << fault.name; }

std::string probed(const std::string& probes) {
  return "bodies:\n  - {name: floor, shape: {plane: {normal: [0, 0, 1]}}}\n  - {name: ball, shape: {sphere: {radius: 0.1}}, "
         "mass: "
         "1}\nprobes:\n" +
         probes;
}

class ProbeRefuses : public testing::TestWithParam<Fault> {};

TEST_P(ProbeRefuses, WithThisMessage) { EXPECT_EQ(fault_of(GetParam().text), GetParam().message); }

const std::vector<Fault> faults{
    {"no_name", probed("  - {box: {low: [0, 0, 0], high: [1, 1, 1]}}\n"),
     "FILE:5: key 'probes[0].name': found nothing, expected a name"},
    {"a_name_with_a_comma", probed("  - {name: 'a,b', box: {low: [0, 0, 0], high: [1, 1, 1]}}\n"),
     "FILE:5: key 'probes[0].name': found 'a,b', expected a name of letters, digits, - and _"},
    {"a_name_twice",
     probed("  - {name: a, box: {low: [0, 0, 0], high: [1, 1, 1]}}\n  - {name: a, box: {low: [0, 0, 0], high: [1, 1, 1]}}\n"),
     "FILE:6: key 'probes[1].name': found a a second time, expected a name of its own for each probe"},
    {"neither", probed("  - {name: a}\n"),
     "FILE:5: key 'probes[0].flow': found nothing, expected a map with point and normal, or box or "
     "stress: one with low and high, or force: one with on, or cell: a name"},
    {"both", probed("  - {name: a, box: {low: [0, 0, 0], high: [1, 1, 1]}, flow: {point: [0, 0, 0], normal: [0, 0, 1]}}\n"),
     "FILE:5: key 'probes[0].box': found box beside flow, expected only one of flow, box, force, stress "
     "and cell"},
    {"box_turned_over", probed("  - {name: a, box: {low: [0, 0, 0], high: [1, -1, 1]}}\n"),
     "FILE:5: key 'probes[0].box.high': found [1, -1, 1], expected a corner that is above the other one along each axis (m)"},
    {"no_such_entry", probed("  - {name: a, of: nobody, box: {low: [0, 0, 0], high: [1, 1, 1]}}\n"),
     "FILE:5: key 'probes[0].of': found nobody, a name that no entry of bodies has, expected the name of an entry of bodies"},
    {"of_the_floor", probed("  - {name: a, of: floor, box: {low: [0, 0, 0], high: [1, 1, 1]}}\n"),
     "FILE:5: key 'probes[0].of': found floor, which the scene moves or holds, expected bodies that are dynamic"},
    {"normal_not_unit", probed("  - {name: a, flow: {point: [0, 0, 0], normal: [0, 0, 2]}}\n"),
     "FILE:5: key 'probes[0].flow.normal': found [0, 0, 2] of length 2, expected a vector of length 1"},
    {"unknown_key", probed("  - {name: a, sphere: {radius: 1}}\n"),
     "FILE:5: key 'probes[0].sphere': found an unknown key, expected name, of, material, flow, box, force, stress or cell"},
};

INSTANTIATE_TEST_SUITE_P(Faults, ProbeRefuses, testing::ValuesIn(faults), [](const auto& each) { return each.param.name; });

}  // namespace
}  // namespace unibody::small_worlds::probes_test
