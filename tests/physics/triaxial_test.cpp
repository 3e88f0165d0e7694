// Plates that press with a force or a pressure: against their area, and Coulomb's wedge between the plates of a triaxial cell.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "joints/joint_set.hpp"
#include "report/probes.hpp"
#include "report/state_hash.hpp"
#include "small_worlds.hpp"

namespace unibody::small_worlds::triaxial_test {

namespace {

std::string number(double x) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.17g", x);
  return text.data();
}

// Solvers, each with one step a frame and with four.
std::vector<std::string> ways() {
  std::vector<std::string> all;
  for (const char* solver : {"accelerated_jacobi", "gauss_seidel"})
    for (const int substeps : {1, 4})
      all.push_back(std::string("gravity: [0, 0, 0]\nsolver: {name: ") + solver +
                    "}\ntime: {frame: 0.01, substeps: " + std::to_string(substeps) + "}\n");
  return all;
}

// N or N m: what the motor of a joint gives.
double motor_of(Experiment& run, std::size_t joint) {
  const Simulation& s = *run.simulation;
  return joint_state(s.scene.joints[joint], s.ties.joint_slots[joint], s.world, s.history.joints()[joint], s.step()).motor;
}

// The columns of the scene's first probe, of one frame.
std::map<std::string, double> frame_of(Experiment& run) {
  Simulation& s = *run.simulation;
  Probes probes(run.scene->probes, run.scene->time.frame, run.scene->period);
  probes.start_frame(s.world);
  for (int k = 0; k < run.scene->time.substeps; ++k) {
    StepRequest request;
    request.impulses = true;
    probes.add_step(s.step(request).impulses);
  }
  std::map<std::string, double> found;
  for (const NamedValue& column : probes.columns(s.comm(), s.world)) found[column.name] = column.value;
  return found;
}

// A block of 0.9 x 0.8 x 0.7 m in a cell of 1 m.
std::string block_between_plates(const std::string& orientation) {
  return R"(
materials: {stone: {friction: 0}}
bodies:
  - name: cell
    triaxial: {size: [1, 1, 1], thickness: 0.1, x: {pressure: 1000}, y: {pressure: 2000}, z: {pressure: [[0, 500], [1, 500], [1.2, 3000]]}}
    material: stone
    orientation: )" +
         orientation + R"(
  - {name: block, shape: {box: {size: [0.9, 0.8, 0.7]}}, mass: 500, material: stone, position: [0, 0, 0.4], orientation: )" +
         orientation + R"(}
probes: [{name: sample, cell: cell}]
)";
}

}  // namespace

// Each plate comes to lie on the block, and presses on the area between the other plates, which is that of the block's face.
TEST(Triaxial, PlatesPressOnTheAreaBetweenTheOthers) {
  for (const std::string& way : ways()) {
    SCOPED_TRACE(way);
    Experiment run(scene_from_text(way + block_between_plates("[1, 0, 0, 0]")));
    const int frame = run.scene->time.substeps;
    run.steps(440 * frame);
    const auto found = frame_of(run);
    EXPECT_NEAR(found.at("sample_size_x (m)"), 0.9, 1e-4);
    EXPECT_NEAR(found.at("sample_size_y (m)"), 0.8, 1e-4);
    EXPECT_NEAR(found.at("sample_size_z (m)"), 0.7, 1e-4);
    EXPECT_NEAR(found.at("sample_pressure_x (Pa)"), 1000, 1);
    EXPECT_NEAR(found.at("sample_pressure_y (Pa)"), 2000, 2);
    EXPECT_NEAR(found.at("sample_pressure_z (Pa)"), 3000, 3);
    EXPECT_NEAR(found.at("sample_solid_fraction (1)"), 1, 1e-3);
    EXPECT_NEAR(motor_of(run, 0), -1000 * 0.8 * 0.7, 0.5);
    EXPECT_NEAR(motor_of(run, 1), -2000 * 0.9 * 0.7, 1);
    EXPECT_NEAR(motor_of(run, 2), -3000 * 0.9 * 0.8, 1.5);
  }
}

// The cell may be turned.
TEST(Triaxial, ATurnedCellDoesTheSame) {
  Experiment run(scene_from_text(ways()[0] + block_between_plates("{axis: [0, 0, 1], angle: 30}")));
  run.steps(440);
  const auto found = frame_of(run);
  EXPECT_NEAR(found.at("sample_size_x (m)"), 0.9, 1e-4);
  EXPECT_NEAR(found.at("sample_pressure_y (Pa)"), 2000, 2);
  EXPECT_NEAR(found.at("sample_solid_fraction (1)"), 1, 1e-3);
}

// A soft cube of edge L between plates without friction comes to homogeneous stretches. Its law is S = C E with Green's strain
// E = (stretch^2 - 1) / 2, and S = F / (L^2 stretch) of the force F of a plate, which presses on the room's area: the cube's
// stretches times L and its thickness.
TEST(Triaxial, ASoftCubeComesToTheStretchesOfItsLaw) {
  constexpr double L = 0.18, thickness = 0.004, modulus = 1e6, poisson = 0.3;
  const Vec3 pressure(2e4, 3e4, 6e4);
  for (const std::string solver : {"accelerated_jacobi", "gauss_seidel"}) {
    Experiment run(scene_from_text("gravity: [0, 0, 0]\nsolver: {iterations: 200, name: " + solver + R"(}
time: {frame: 0.01, substeps: 4}
materials: {rubber: {friction: 0}}
bodies:
  - name: cell
    triaxial: {size: [0.2, 0.2, 0.2], thickness: 0.05, x: {pressure: 2.0e+4}, y: {pressure: 3.0e+4}, z: {pressure: 6.0e+4}}
    material: rubber
solids:
  - {name: cube, block: {size: [0.18, 0.18, 0.18], cells: [2, 2, 2]}, density: 1000, youngs_modulus: 1.0e+6, poissons_ratio: 0.3,
     thickness: 0.004, material: rubber, position: [0, 0, 0.1]}
probes: [{name: sample, cell: cell}]
)"));
    run.steps(4 * 250);
    const auto found = frame_of(run);
    const Vec3 room(found.at("sample_size_x (m)"), found.at("sample_size_y (m)"), found.at("sample_size_z (m)"));
    const Vec3 stretch = (room.array() - thickness) / L,
               S = (pressure.array() * room.prod() / room.array() / (L * L)) / stretch.array();
    for (int k = 0; k < 3; ++k) {
      const double strain = -(S[k] - poisson * (S.sum() - S[k])) / modulus;
      EXPECT_NEAR(0.5 * (stretch[k] * stretch[k] - 1), strain, 1e-3) << solver << ' ' << k;
    }
    EXPECT_LT(stretch[2], 0.96) << solver;
  }
}

// A planar cell has no plates along y: its size along y is the depth of all areas.
TEST(Triaxial, APlanarCellHasTheDepthThatItSays) {
  Experiment run(scene_from_text(ways()[0] + R"(
planar: true
materials: {stone: {friction: 0}}
bodies:
  - {name: cell, triaxial: {size: [1, 3, 1], thickness: 0.1, x: {pressure: 1000}, z: {pressure: 500}}, material: stone}
  - {name: block, shape: {box: {size: [0.9, 1, 0.7]}}, mass: 500, material: stone, position: [0, 0, 0.4]}
probes: [{name: sample, cell: cell}]
)"));
  run.steps(440);
  const auto found = frame_of(run);
  EXPECT_NEAR(found.at("sample_size_x (m)"), 0.9, 1e-4);
  EXPECT_NEAR(found.at("sample_size_z (m)"), 0.7, 1e-4);
  EXPECT_EQ(found.count("sample_size_y (m)"), 0u);
  EXPECT_NEAR(found.at("sample_pressure_x (Pa)"), 1000, 1);
  EXPECT_NEAR(motor_of(run, 0), -1000 * 3 * 0.7, 2);
  EXPECT_NEAR(motor_of(run, 1), -500 * 3 * 0.9, 1.5);
}

// Nothing is between them: the room closes as fast as it may, by closing_speed, else by a tenth of its side a second.
TEST(Triaxial, AnEmptyRoomClosesAtItsSpeed) {
  for (const std::string& way : ways()) {
    Experiment run(scene_from_text(way + R"(
bodies:
  - name: cell
    triaxial: {size: [2, 1, 1], thickness: 0.1, x: {pressure: 1.0e+5}, z: {closing_speed: [[0, 0.2], [0.5, 0.2], [0.501, -0.1]]}}
probes: [{name: sample, cell: cell}]
)"));
    run.steps(99 * run.scene->time.substeps);
    const auto found = frame_of(run);
    EXPECT_NEAR(found.at("sample_size_x (m)"), 2 - 0.2, 2e-3) << way;
    EXPECT_EQ(found.at("sample_size_y (m)"), 1) << way;
    EXPECT_NEAR(found.at("sample_size_z (m)"), 1 - 0.1 + 0.05, 2e-3) << way;
  }
}

namespace {

// A block of 1 x 1 x 2.5 m, cut by a plane at 60 degrees that leaves it at its sides; sigma_x = 1e4 Pa, and sigma_z.
std::string wedge(double sigma_z) {
  const double low = 0.5 * (2.5 - std::sqrt(3.0)), high = low + std::sqrt(3.0);
  std::string text = R"(
materials: {plate: {friction: 0}, rock: {friction: 0.5}}
bodies:
  - name: cell
    triaxial: {size: [1, 1, 2.5], thickness: 0.2, density: 500, x: {pressure: 1.0e+4}, z: {pressure: )" +
                     number(sigma_z) + R"(}}
    material: plate
)";
  const auto body = [&](const char* name, const std::vector<std::array<double, 2>>& outline) {
    std::string vertices;
    double area = 0;
    Vec3 middle = Vec3::Zero();
    for (std::size_t i = 0; i < outline.size(); ++i) {
      const auto &p = outline[i], &q = outline[(i + 1) % outline.size()];
      const double part = 0.5 * (p[0] * q[1] - p[1] * q[0]);
      area += part, middle += part / 3 * Vec3(p[0] + q[0], 0, p[1] + q[1]);
    }
    middle /= area;
    for (const double y : {-0.49, 0.49})
      for (const auto& [x, z] : outline)
        vertices += (vertices.empty() ? "[" : ", [") + number(x) + ", " + number(y) + ", " + number(z) + "]";
    text += std::string("  - {name: ") + name + ", shape: {hull: {points: [" + vertices +
            "]}}, density: 1000, material: rock, position: [" + number(middle.x() - 0.5) + ", 0, " + number(middle.z()) + "]}\n";
  };
  body("lower", {{0, 0}, {1, 0}, {1, high}, {0, low}});
  body("upper", {{0, low}, {1, high}, {1, 2.5}, {0, 2.5}});
  return text + "probes: [{name: sample, cell: cell}]\n";
}

}  // namespace

// The upper part slides down the cut, and pushes the lower one against the plate along x, where P (sin a - mu cos a) is more than
// Q (cos a + mu sin a), P and Q being the forces of the plates (Coulomb 1773). P and Q are the pressures times areas of 1
// and 2.5.
TEST(Triaxial, ACutBlockSlidesWhereCoulombSays) {
  const double a = M_PI / 3, mu = 0.5;
  const double limit = 2.5 * 1e4 * (std::cos(a) + mu * std::sin(a)) / (std::sin(a) - mu * std::cos(a));
  for (const std::string& way : ways())
    for (const double share : {0.95, 1.05}) {
      Experiment run(scene_from_text(way + wedge(share * limit)));
      run.steps(100 * run.scene->time.substeps);
      const auto found = frame_of(run);
      if (share < 1) {
        EXPECT_NEAR(found.at("sample_size_z (m)"), 2.5, 2e-3) << way;
        EXPECT_NEAR(found.at("sample_size_x (m)"), 1, 2e-3) << way;
        EXPECT_NEAR(found.at("sample_pressure_z (Pa)"), share * limit, 0.01 * limit) << way;
      } else {
        EXPECT_LT(found.at("sample_size_z (m)"), 2.45) << way;
        EXPECT_GT(found.at("sample_size_x (m)"), 1.01) << way;
      }
    }
}

// A plate on a slider, outside of any cell: with a force and with a pressure on an area, which may change in time.
TEST(Triaxial, ASliderPressesByForceOrPressure) {
  for (const std::string& way : ways())
    for (const std::string most :
         {"max_force: [[0, 10], [0.5, 10], [0.6, 40]]", "max_pressure: [[0, 5], [0.5, 5], [0.6, 20]], area: 2"}) {
      Experiment run(scene_from_text(way + R"(
bodies:
  - {name: block, shape: {box: {size: [1, 1, 1]}}, mass: 3, position: [0, 0, 0.5]}
  - {name: ground, shape: {plane: {normal: [0, 0, 1]}}}
  - {name: plate, shape: {box: {size: [1, 1, 0.1]}}, mass: 2, position: [0, 0, 1.06]}
joints: [{type: slider, bodies: [plate, world], anchor: [0, 0, 1.06], axis: [0, 0, 1], motor: {speed: -0.1, )" +
                                     most + R"(}}]
probes: [{name: floor, force: {on: ground}}]
)"));
      run.steps(49 * run.scene->time.substeps);
      EXPECT_NEAR(frame_of(run).at("floor_force_z (N)"), -10, 0.05) << way << most;
      run.steps(50 * run.scene->time.substeps);
      EXPECT_NEAR(frame_of(run).at("floor_force_z (N)"), -40, 0.2) << way << most;
    }
}

TEST(RanksTriaxial, StepsHaveTheSameBits) {
  int ranks = 1;
  MPI_Comm_size(MPI_COMM_WORLD, &ranks);
  for (const std::string solver : {"accelerated_jacobi", "gauss_seidel"}) {
    const std::string text = R"(
gravity: [0, 0, 0]
bodies:
  - name: cell
    triaxial: {size: [0.4, 0.4, 0.4], thickness: 0.05, density: 500, x: {pressure: 3000, closing_speed: 0.2},
               y: {pressure: 3000, closing_speed: 0.2}, z: {pressure: 6000, closing_speed: 0.2}}
  - name: grains
    lattice: {count: 125, columns: [5, 5], spacing: [0.078, 0.078, 0.078], height: 0.04, jitter: 0.002}
    shape: {sphere: {radius: 0.036}}
    density: 2000
probes: [{name: sample, cell: cell}]
solver: {name: )" + solver + "}\ntime: {frame: 0.01, substeps: 2}\n";
    Experiment alone(scene_from_text(text)), together(scene_from_text(text), MPI_COMM_WORLD);
    alone.steps(20), together.steps(20);
    std::vector<int> home;
    for (std::size_t i = 0; i < together.world().homes; ++i) home.push_back(static_cast<int>(together.world().id[i] / 2) % ranks);
    together.simulation->move_homes(home);
    alone.steps(40), together.steps(40);
    EXPECT_EQ(state_hash(MPI_COMM_SELF, alone.world()), state_hash(MPI_COMM_WORLD, together.world())) << solver;
    const auto one = frame_of(alone), all = frame_of(together);
    EXPECT_EQ(one, all) << solver;
    EXPECT_LT(one.at("sample_size_z (m)"), 0.395) << solver;
    EXPECT_GT(one.at("sample_pressure_z (Pa)"), 3000) << solver;
  }
}

}  // namespace unibody::small_worlds::triaxial_test
