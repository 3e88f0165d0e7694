// Forces and stresses that probes read, against the momentum that they give, weights, and closed forms.
#include <gtest/gtest.h>

#include <map>

#include "partition/balance.hpp"
#include "report/loaded_bodies.hpp"
#include "report/probes.hpp"
#include "scene/scene_text.hpp"
#include "small_worlds.hpp"
#include "step/step_parts.hpp"

namespace unibody::small_worlds::forces_test {
namespace {

using Row = std::map<std::string, double>;

Row take_frame(Experiment& run, MPI_Comm comm, int steps = 1) {
  Probes probes(run.scene->probes, steps * run.h(), run.scene->period);
  probes.start_frame(run.world());
  StepRequest request;
  request.impulses = probes.wants_impulses();
  for (int k = 0; k < steps; ++k) probes.add_step(run.simulation->step(request).impulses);
  Row row;
  for (const NamedValue& column : probes.columns(comm, run.world()))
    if (column.known) row[column.name] = column.value;
  return row;
}

Vec3 vector_of(const Row& row, const std::string& name, const std::string& unit) {
  return {row.at(name + "_x" + unit), row.at(name + "_y" + unit), row.at(name + "_z" + unit)};
}
Vec3 force_of(const Row& row, const std::string& probe) { return vector_of(row, probe + "_force", " (N)"); }
Vec3 torque_of(const Row& row, const std::string& probe) { return vector_of(row, probe + "_torque", " (N m)"); }

std::string settings(const char* solver, int substeps, const std::string& more = "") {
  return std::string("solver: {name: ") + solver + more + "}\ntime: {frame: 0.016, substeps: " + std::to_string(substeps) + "}\n";
}

struct Way {
  const char* solver;
  int substeps;
};
constexpr Way ways[] = {{"accelerated_jacobi", 1}, {"accelerated_jacobi", 4}, {"gauss_seidel", 1}, {"gauss_seidel", 4}};

// Whatever the solver leaves undone: what bodies gain of momentum and of angular momentum is what gravity and walls give them.
// Impacts that bounce, in the middle of steps, and contacts that stick and slide.
TEST(Forces, AreWhatChangesMomentum) {
  const std::string bodies =
      "materials: {m: {friction: 0.4, restitution: 0.6}}\nbodies:\n  - {name: walls, container: {size: [0.6, 0.6]}}\n"
      "  - {pile: {count: 40, columns: [3, 3], mix: [{shape: {sphere: {radius: 0.06}}, scale: [0.7, 1.2]}, "
      "{shape: {box: {size: [0.1, 0.08, 0.06]}}, scale: [0.8, 1.2]}]}, density: 2000, position: [0, 0, 0.1], velocity: [1, 0.5, "
      "-2]}\n"
      "probes:\n  - {name: walls, force: {on: walls}}\n";
  for (const Way& way : ways) {
    Experiment run(scene_from_text(settings(way.solver, way.substeps) + bodies));
    double mass = 0;
    for (std::size_t i = 0; i < run.world().homes; ++i) mass += run.world().properties[i].mass;
    double most = 0;
    for (int frame = 0; frame < 40; ++frame) {
      const Vec3 before = run.momentum();
      const Row row = take_frame(run, MPI_COMM_SELF, way.substeps);
      const double time = way.substeps * run.h();
      const Vec3 given = (run.momentum() - before) / time - mass * run.scene->gravity, force = force_of(row, "walls");
      EXPECT_LT((given + force).norm(), 1e-9 * mass * 9.81) << way.solver << ' ' << way.substeps << ' ' << frame;
      most = std::max(most, force.norm());
    }
    EXPECT_GT(most, 4 * mass * 9.81);  // the impact
  }
}

// Forces that pull count as such, and those across the borders of a periodic scene cancel.
TEST(Forces, OfAdhesionAndAcrossBordersAreWhatChangesMomentum) {
  const std::string bodies =
      "periodic: {x: [0, 0.9], y: [0, 0.9]}\ngravity: [2, 0, -9.81]\nmaterials: {m: {friction: 0.4, adhesion: 5}}\n"
      "bodies:\n  - {name: walls, shape: {plane: {normal: [0, 0, 1]}}}\n"
      "  - {pile: {count: 40, columns: [3, 3], mix: [{shape: {sphere: {radius: 0.06}}, scale: [0.7, 1.2]}, "
      "{shape: {box: {size: [0.1, 0.08, 0.06]}}, scale: [0.8, 1.2]}]}, density: 1000, position: [0, 0, 0.1]}\n"
      "probes:\n  - {name: walls, force: {on: walls}}\n";
  for (const Way& way : ways) {
    Experiment run(scene_from_text(settings(way.solver, way.substeps) + bodies));
    double mass = 0;
    for (std::size_t i = 0; i < run.world().homes; ++i) mass += run.world().properties[i].mass;
    for (int frame = 0; frame < 60; ++frame) {
      const Vec3 before = run.momentum();
      const Vec3 force = force_of(take_frame(run, MPI_COMM_SELF, way.substeps), "walls");
      const Vec3 given = (run.momentum() - before) / (way.substeps * run.h()) - mass * run.scene->gravity;
      EXPECT_LT((given + force).norm(), 1e-9 * mass * 9.81) << way.solver << ' ' << way.substeps << ' ' << frame;
    }
  }
  // A ball hangs from a ceiling, which it pulls down by its weight, whatever the attraction.
  Experiment hangs(scene_from_text(
      "materials: {m: {friction: 0.4, adhesion: 50}}\nbodies:\n  - {name: ceiling, shape: {plane: {normal: [0, 0, -1]}}}\n"
      "  - {shape: {sphere: {radius: 0.1}}, mass: 2, position: [0, 0, -0.1]}\nprobes:\n  - {name: c, force: {on: ceiling}}\n"));
  hangs.seconds(0.8);
  EXPECT_LT((force_of(take_frame(hangs, MPI_COMM_SELF), "c") - Vec3(0, 0, -2 * 9.81)).norm(), 1e-3);
}

// An impact in the middle of the step turns a ball by the friction that acts at the moment of it.
TEST(Forces, OfAnImpactTurnTheBall) {
  for (const Way& way : ways) {
    Experiment run(scene_from_text(
        settings(way.solver, way.substeps) +
        "gravity: [0, 0, 0]\nmaterials: {m: {friction: 0.3, restitution: 0.5}}\nbodies:\n"
        "  - {name: floor, shape: {plane: {normal: [0, 0, 1]}}}\n"
        "  - {name: ball, shape: {sphere: {radius: 0.1}}, mass: 2, position: [0, 0, 0.11], velocity: [6, 0, -2]}\n"
        "probes:\n  - {name: ball, force: {on: ball, about: [0, 0, 0]}}\n"));
    Vec3 impulse = Vec3::Zero();
    for (int frame = 0; frame < 3; ++frame) impulse += 0.016 * force_of(take_frame(run, MPI_COMM_SELF, way.substeps), "ball");
    EXPECT_NEAR(impulse.z(), 2 * (2 + 1), 1e-9);
    EXPECT_NEAR(impulse.x(), -0.3 * 2 * (2 + 1), 1e-9);
    EXPECT_NEAR(run.state(1).angular_velocity.y(), 0.1 * 0.3 * 6 / (0.4 * 2 * 0.01), 1e-9);
  }
}

// A box at rest: its weight, split between the plate it stands on, off its middle, and the torque about a point.
TEST(Forces, OfWhatRestsAreItsWeight) {
  const std::string text =
      "materials: {m: {friction: 0.5}}\nbodies:\n"
      "  - {name: plate, shape: {box: {size: [2, 2, 0.1]}}, motion: fixed, position: [0, 0, -0.05]}\n"
      "  - {name: heavy, shape: {box: {size: [0.2, 0.2, 0.2]}}, mass: 3, position: [0.5, 0.3, 0.1]}\n"
      "  - {name: light, shape: {box: {size: [0.2, 0.2, 0.2]}}, mass: 1, points: [[-0.4, 0, 0.1], [0.5, 0.3, 0.3]]}\n"
      "probes:\n  - {name: all, force: {on: plate}}\n  - {name: off, force: {on: plate, about: [0.5, 0.3, 0]}}\n"
      "  - {name: of_light, force: {on: plate, by: light}}\n  - {name: upper, force: {on: 'light[1]'}}\n"
      "  - {name: heavy, force: {on: heavy}}\n  - {name: within, force: {on: light, by: plate}}\n";
  const double g = 9.81;
  for (const Way& way : ways) {
    Experiment run(scene_from_text(settings(way.solver, way.substeps, ", iterations: 400, tolerance: 1.0e-9") + text));
    run.seconds(1);
    const Row row = take_frame(run, MPI_COMM_SELF, 40 * way.substeps);  // what moves a little is pushed to and fro
    const double some = 1e-4 * 5 * g;
    EXPECT_LT((force_of(row, "all") - Vec3(0, 0, -5 * g)).norm(), some) << way.solver << ' ' << way.substeps;
    EXPECT_LT((force_of(row, "of_light") - Vec3(0, 0, -g)).norm(), some);
    EXPECT_LT((force_of(row, "within") - Vec3(0, 0, g)).norm(), some);
    EXPECT_LT((force_of(row, "upper") - Vec3(0, 0, g)).norm(), some);
    EXPECT_LT((force_of(row, "heavy") - Vec3(0, 0, 3 * g)).norm(), some);  // 4 g from below, 1 g from above
    const Vec3 about_origin = Vec3(0.5, 0.3, 0).cross(Vec3(0, 0, -4 * g)) + Vec3(-0.4, 0, 0).cross(Vec3(0, 0, -g));
    EXPECT_LT((torque_of(row, "all") - about_origin).norm(), some);
    const Vec3 about_heavy = Vec3(-0.9, -0.3, 0).cross(Vec3(0, 0, -g));
    EXPECT_LT((torque_of(row, "off") - about_heavy).norm(), some);
  }
}

// On a slope that holds: the normal force and the friction of statics.
TEST(Forces, OnASlopeAreThoseOfStatics) {
  Experiment run(scene_from_text(
      "gravity: [3, 0, -8]\nmaterials: {m: {friction: 0.6}}\nbodies:\n  - {name: floor, shape: {plane: {normal: [0, 0, 1]}}}\n"
      "  - {shape: {box: {size: [0.4, 0.4, 0.1]}}, mass: 2, position: [0, 0, 0.05]}\n"
      "probes:\n  - {name: floor, force: {on: floor}}\n"));
  run.seconds(1);
  EXPECT_LT((force_of(take_frame(run, MPI_COMM_SELF), "floor") - Vec3(6, 0, -16)).norm(), 1e-4 * 17);
}

// A cloth that has fallen on a fixed box, and hangs over it: momentum again, of nodes.
TEST(Forces, OfAClothAreWhatChangesItsMomentum) {
  for (const Way& way : ways) {
    Experiment run(
        scene_from_text(settings(way.solver, way.substeps) +
                        "materials: {m: {friction: 0.5}}\nbodies:\n"
                        "  - {name: table, shape: {box: {size: [0.4, 0.4, 0.2]}}, motion: fixed, position: [0, 0, -0.1]}\n"
                        "cloths:\n  - {name: cloth, grid: {size: [0.8, 0.8], nodes: [17, 17]}, mass: 0.5, thickness: 0.01, "
                        "position: [0, 0, 0.03], "
                        "links: {stiffness: 500}}\n"
                        "probes:\n  - {name: table, force: {on: table}}\n  - {name: cloth, force: {on: cloth, by: table}}\n"));
    double most = 0;
    for (int frame = 0; frame < 30; ++frame) {
      const Vec3 before = run.momentum();
      const Row row = take_frame(run, MPI_COMM_SELF, way.substeps);
      const Vec3 given = (run.momentum() - before) / (way.substeps * run.h()) - 0.5 * run.scene->gravity;
      if (run.last.guard.pairs > 0) continue;  // what the guard holds is no contact's
      EXPECT_LT((given - force_of(row, "cloth")).norm(), 1e-9) << way.solver << ' ' << way.substeps << ' ' << frame;
      EXPECT_LT((force_of(row, "cloth") + force_of(row, "table")).norm(), 1e-9);
      most = std::max(most, given.norm());
    }
    EXPECT_GT(most, 1);
  }
}

// A column of n cubes of mass m and side a: the k-th contact from above bears k m g along a branch of a (the lowest of a / 2,
// from the ground), so that in a box about all of it the stress is the sum over its room. Across it there is none.
TEST(Stress, OfAColumnIsItsWeightOverItsSection) {
  const int n = 6;
  const double a = 0.1, m = 2, g = 9.81;
  Experiment run(scene_from_text(
      "solver: {iterations: 400}\nmaterials: {m: {friction: 0.5}}\nbodies:\n  - {name: floor, shape: {plane: {normal: [0, 0, "
      "1]}}}\n"
      "  - {shape: {box: {size: [0.1, 0.1, 0.1]}}, mass: 2, points: [[0, 0, 0.05], [0, 0, 0.15], [0, 0, 0.25], [0, 0, 0.35], "
      "[0, 0, 0.45], [0, 0, 0.55]]}\n"
      "probes:\n  - {name: all, stress: {low: [-0.06, -0.06, -0.01], high: [0.06, 0.06, 0.59]}}\n"
      "  - {name: middle, stress: {low: [-0.06, -0.06, 0.15], high: [0.06, 0.06, 0.25]}}\n"));
  run.seconds(2);
  const Row row = take_frame(run, MPI_COMM_SELF, 40);
  double sum = 0.5 * n;
  for (int k = 1; k < n; ++k) sum += k;
  const double expected = sum * m * g * a / (0.12 * 0.12 * 0.6);
  EXPECT_NEAR(row.at("all_stress_zz (Pa)"), expected, 1e-3 * expected);
  EXPECT_NEAR(row.at("all_stress_xx (Pa)"), 0, 1e-3 * expected);
  EXPECT_NEAR(row.at("middle_stress_zz (Pa)"), 4 * m * g * a / (0.12 * 0.12 * 0.1), 1e-3 * expected);
  EXPECT_NEAR(row.at("middle_stress_xx (Pa)"), 0, 1e-3 * expected);
  EXPECT_NEAR(row.at("middle_stress_xz (Pa)"), 0, 1e-3 * expected);
}

// The same column, body by body: the k-th cube from above bears k m g from below and (k - 1) m g from above, each half an edge
// away from its centre, and touches the one above it, the one below it or the ground.
TEST(Stress, OfEachCubeOfAColumn) {
  const double a = 0.1, m = 2, g = 9.81;
  Experiment run(
      scene_from_text("solver: {iterations: 400}\nmaterials: {m: {friction: 0.5}}\nbodies:\n  - {name: floor, shape: {plane: "
                      "{normal: [0, 0, 1]}}}\n"
                      "  - {shape: {box: {size: [0.1, 0.1, 0.1]}}, mass: 2, points: [[0, 0, 0.05], [0, 0, 0.15], [0, 0, 0.25], "
                      "[0, 0, 0.35]]}\n"));
  run.seconds(0.5);
  StepRequest request;
  request.impulses = true;
  const auto bodies = loaded_bodies(run.simulation->step(request).impulses, *run.scene, run.h());
  ASSERT_EQ(bodies.size(), 4U);
  for (int k = 0; k < 4; ++k) {
    EXPECT_EQ(bodies[static_cast<std::size_t>(k)].id, k + 1);
    EXPECT_EQ(bodies[static_cast<std::size_t>(k)].coordination, k == 3 ? 1 : 2);
    const double below = (4 - k) * m * g, above = (3 - k) * m * g;
    const auto& stress = bodies[static_cast<std::size_t>(k)].stress;
    EXPECT_NEAR(stress[2], 0.5 * (below + above) / (a * a), 1e-3 * 4 * m * g / (a * a));
    for (const std::size_t part : {0U, 1U, 3U, 4U, 5U}) EXPECT_NEAR(stress[part], 0, 1e-3 * 4 * m * g / (a * a));
  }
}

// Of spheres of known velocities: the temperature is a third of the mean square about the mean, by mass.
TEST(Stress, ABoxTellsTemperatureAndSolidFraction) {
  Experiment run(
      scene_from_text("gravity: [0, 0, 0]\ntime: {frame: 1.0e-6}\nbodies:\n"
                      "  - {shape: {sphere: {radius: 0.1}}, mass: 1, position: [0.3, 0.5, 0.5], velocity: [3, 0, 0]}\n"
                      "  - {shape: {sphere: {radius: 0.2}}, mass: 2, position: [0.7, 0.5, 0.5], velocity: [0, 3, 0]}\n"
                      "probes:\n  - {name: room, box: {low: [0, 0, 0], high: [1, 1, 2]}}\n"));
  const Row row = take_frame(run, MPI_COMM_SELF);
  EXPECT_NEAR(row.at("room_temperature (m^2/s^2)"), (9.0 - (1.0 + 4.0)) / 3, 1e-12);  // mean velocity (1, 2, 0)
  EXPECT_NEAR(row.at("room_solid_fraction (1)"), 4 * M_PI / 3 * (0.001 + 0.008) / 2, 1e-12);
}

TEST(RanksForces, AreTheSameBits) {
  const std::string text =
      "time: {frame: 0.02, substeps: 2}\nsolver: {iterations: 10}\nmaterials: {m: {friction: 0.4, restitution: 0.5}}\nbodies:\n"
      "  - {name: walls, container: {size: [0.6, 0.6]}}\n"
      "  - {name: bead, pile: {count: 120, columns: [4, 4], mix: [{shape: {sphere: {radius: 0.04}}, scale: [0.6, 1.3]}]}, "
      "density: 2000, position: [0, 0, 0.1]}\n"
      "cloths:\n  - {name: cloth, grid: {size: [0.4, 0.4], nodes: [9, 9]}, mass: 0.3, thickness: 0.01, position: [0, 0, 1.2], "
      "velocity: [0, 0, -3]}\n"
      "probes:\n  - {name: walls, force: {on: walls}}\n  - {name: beads, force: {on: bead, by: cloth}}\n"
      "  - {name: low, stress: {low: [-9, -9, -9], high: [9, 9, 0.3]}}\n  - {name: room, box: {low: [-9, -9, 0], high: [9, 9, "
      "0.3]}}\n";
  Experiment alone(scene_from_text(text)), run(scene_from_text(text), MPI_COMM_WORLD);
  const Balance balance(MPI_COMM_WORLD, 3, true);
  run.simulation->move_homes(balance.homes(parts_of(*run.simulation)));
  double most = 0;
  for (int k = 0; k < 30; ++k) {
    const Row one = take_frame(alone, MPI_COMM_SELF, 2), all = take_frame(run, MPI_COMM_WORLD, 2);
    ASSERT_EQ(one, all) << k;
    most = std::max(most, force_of(one, "beads").norm());
  }
  EXPECT_GT(most, 0.5);
}

struct Fault {
  const char* name;
  std::string probe, message;
};
void PrintTo(const Fault& fault, std::ostream* out) { *out << fault.name; }

class ForceRefuses : public testing::TestWithParam<Fault> {};

TEST_P(ForceRefuses, WithThisMessage) {
  const std::string text =
      "bodies:\n  - {name: floor, shape: {plane: {normal: [0, 0, 1]}}}\n  - {name: ball, shape: {sphere: {radius: 0.1}}, mass: "
      "1, "
      "points: [[0, 0, 1], [0, 0, 2]]}\nprobes:\n  - " +
      GetParam().probe + "\n";
  EXPECT_EQ(fault_of(text), "FILE:5: key 'probes[0]." + GetParam().message);
}

const std::string an_entry = "the name of an entry of bodies, cloths, threads or solids, or one of its bodies as name[0]";
const std::vector<Fault> faults{
    {"on_nothing", "{name: a, force: {by: ball}}", "force.on': found nothing, expected the name of an entry"},
    {"no_such_entry", "{name: a, force: {on: flor}}",
     "force.on': found flor, a name that no entry has (did you mean floor?), expected " + an_entry},
    {"no_such_number", "{name: a, force: {on: 'ball[2]'}}", "force.on': found 'ball[2]' of 2, expected a number below 2"},
    {"by_no_one", "{name: a, force: {on: ball, by: cube}}",
     "force.by': found cube, a name that no entry has, expected " + an_entry},
    {"beside_of", "{name: a, of: ball, force: {on: floor}}",
     "of': found ball, expected no such key beside force, which has on and by"},
    {"two_kinds", "{name: a, force: {on: floor}, box: {low: [0, 0, 0], high: [1, 1, 1]}}",
     "force': found force beside box, expected only one of flow, box, force, stress and cell"},
    {"stress_of_a_material", "{name: a, of: ball, stress: {low: [0, 0, 0], high: [1, 1, 1]}}",
     "of': found ball, expected no such key beside stress, which is that of all contacts in its box"},
    {"unknown_key", "{name: a, force: {on: ball, at: [0, 0, 0]}}", "force.at': found an unknown key, expected on, by or about"},
};

INSTANTIATE_TEST_SUITE_P(Faults, ForceRefuses, testing::ValuesIn(faults), [](const auto& each) { return each.param.name; });

}  // namespace
}  // namespace unibody::small_worlds::forces_test
