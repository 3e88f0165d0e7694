// Drag of the air on cloths against closed forms and direct sums.
#include <gtest/gtest.h>

#include <cmath>

#include "collide/bodies.hpp"
#include "small_worlds.hpp"

namespace unibody::small_worlds::wind_test {

namespace {

using unibody::samples::Random;

// A sheet of 1 m x 0.8 m in the plane z = 0, of 0.2 kg/m^2.
std::string sheet(const std::string& drag, const std::string& scene, const std::string& more = "links: {diagonals: both}") {
  return scene +
         "\ncloths:\n  - grid: {size: [1, 0.8], nodes: [6, 5]}\n    mass_per_area: 0.2\n    thickness: 0.01\n    drag: " + drag +
         "\n    " + more + "\n";
}

// A crumpled sheet in disorderly motion whose links bear next to nothing.
Experiment crumpled(const std::string& drag, const std::string& scene, bool one_velocity = false) {
  Experiment run(scene_from_text(sheet(drag, "gravity: [0, 0, 0]\n" + scene, "links: {stiffness: 1.0e-9}")));
  Random random(5);
  World& world = run.world();
  for (std::size_t i = 0; i < world.homes; ++i) {
    world.position[i] += Vec3(random(-.05, .05), random(-.05, .05), random(-.2, .2));
    world.velocity[i] = one_velocity ? Vec3(1, 2, 3) : Vec3(random(-5, 5), random(-5, 5), random(-5, 5));
  }
  return run;
}

// J, in the frame of the wind.
double energy_against(const World& world, const Vec3& wind) {
  double sum = 0;
  for (std::size_t i = 0; i < world.homes; ++i) sum += 0.5 * world.properties[i].mass * (world.velocity[i] - wind).squaredNorm();
  return sum;
}

const char* const coefficients[] = {"1.0e-3", "1", "1.0e+3", "1.0e+9", "1.0e+300"};

}  // namespace

// Speed v_t tanh(g t / v_t), v_t = sqrt(2 m g / (rho C A)): on the way to first order in the step, at the end to round-off, and
// the sheet stays flat, since each triangle's share of its nodes feels the same.
TEST(Wind, AFallingSheetReachesItsTerminalVelocity) {
  for (const double density : {1.2, 0.3}) {
    const double area = 0.8, mass = 0.2 * area, C = 1.5, terminal = std::sqrt(2 * mass * 9.81 / (density * C * area));
    Scene scene = scene_from_text(sheet("1.5", "air_density: " + std::to_string(density)));
    scene.time.frame = 0.004;
    Experiment run(std::move(scene));
    EXPECT_NEAR(run.world().properties[0].mass, 0.2 * 0.05 * 0.2, 0.002);
    run.seconds(0.2);
    EXPECT_NEAR(-run.velocity(7).z(), terminal * std::tanh(9.81 * 0.2 / terminal), 0.02 * terminal) << density;
    run.seconds(5);
    for (Id id = 0; id < 30; ++id) {
      EXPECT_NEAR(-run.velocity(id).z(), terminal, 1e-10) << density;
      EXPECT_NEAR(run.position(id).z(), run.position(0).z(), 1e-10) << density;
    }
  }
}

TEST(Wind, AlongTheSheetDoesNothing) {
  Experiment along(scene_from_text(sheet("2", "gravity: [0, 0, 0]\nwind: [5, -3, 0]")));
  Experiment across(scene_from_text(sheet("2", "gravity: [0, 0, 0]\nwind: [5, -3, 1]")));
  Experiment without(scene_from_text(sheet("0", "gravity: [0, 0, 0]\nwind: [5, -3, 1]")));
  for (Experiment* run : {&along, &across, &without}) run->steps(20);
  for (Id id = 0; id < 30; ++id) {
    EXPECT_EQ(along.velocity(id), Vec3::Zero());
    EXPECT_EQ(without.velocity(id), Vec3::Zero());
    EXPECT_GT(across.velocity(id).z(), 0.1);
  }
}

// A small coefficient: the momentum of a step is the sum over triangles of -rho/2 C A |u_n| u_n n.
TEST(Wind, TheForceIsThatOfTheTriangles) {
  Experiment run = crumpled("1.0e-7", "wind: [4, 0, -1]", true);
  const Vec3 p = run.momentum(), u = Vec3(1, 2, 3) - Vec3(4, 0, -1);
  Vec3 force = Vec3::Zero();
  const Surface& surface = run.scene->surfaces[0];
  for (Id k = 0; k < surface.count; ++k) {
    const auto ids = surface.cell(k);
    const Vec3 n = (run.position(ids[1]) - run.position(ids[0])).cross(run.position(ids[2]) - run.position(ids[0]));
    const double along = u.dot(n.normalized());
    force -= 0.5 * 1.2 * 1e-7 * (0.5 * n.norm()) * std::abs(along) * along * n.normalized();
  }
  const double h = run.h();
  run.step();
  EXPECT_GT(force.norm(), 1e-7);
  EXPECT_LT(((run.momentum() - p) / h - force).norm(), 1e-5 * force.norm());
}

// A wind that grows within the step pushes as its mean.
TEST(Wind, OneThatChangesInTimePushesAsItsMean) {
  Experiment changing = crumpled("0.1", "wind: [4, {sine: {mean: 1, amplitude: 0, frequency: 1}}, [[0, -1], [0.016, -3]]]", true),
             constant = crumpled("0.1", "wind: [4, 1, -2]", true), start = crumpled("0.1", "wind: [4, 1, -1]", true);
  changing.step(), constant.step(), start.step();
  EXPECT_LT((changing.momentum() - constant.momentum()).norm(), 1e-13);
  EXPECT_GT((start.momentum() - constant.momentum()).norm(), 1e-5);
}

// At any coefficient the sheet comes to rest against the air at most, and the closer the larger it is.
TEST(Wind, AHugeCoefficientDoesNotOvershoot) {
  double before = 3;
  for (const char* drag : coefficients) {
    Experiment run(scene_from_text(sheet(drag, "gravity: [0, 0, 0]\nwind: [0, 0, 1]", "velocity: [0, 0, 4]")));
    run.step();
    for (Id id = 0; id < 30; ++id) {
      EXPECT_GE(run.velocity(id).z() - 1, -1e-14) << drag;
      EXPECT_LT(run.velocity(id).z() - 1, before) << drag;
    }
    before = run.velocity(0).z() - 1 + 1e-13;
  }
  EXPECT_LT(before, 1e-12);
}

TEST(Wind, EnergyInTheFrameOfTheWindNeverGrows) {
  for (const char* drag : coefficients)
    for (const Vec3& wind : {Vec3(0, 0, 0), Vec3(3, -2, 1)}) {
      std::ostringstream text;
      text << "wind: [" << wind.x() << ", " << wind.y() << ", " << wind.z() << "]\n";
      Experiment run = crumpled(drag, text.str());
      double energy = energy_against(run.world(), wind);
      for (int k = 0; k < 20; ++k) {
        run.step();
        const double next = energy_against(run.world(), wind);
        EXPECT_LT(next, energy) << drag << ' ' << k;
        energy = next;
      }
      EXPECT_TRUE(run.finite());
    }
}

// A pinned node stays; the air takes hold of the others all the same.
TEST(Wind, PinnedNodesStay) {
  Experiment run(
      scene_from_text(sheet("1.0e+6", "gravity: [0, 0, 0]\nwind: [0, 0, 2]", "pins: [{node: [0, 0]}, {node: [5, 0]}]")));
  const Vec3 held = run.position(0);
  run.steps(30);
  EXPECT_EQ(run.position(0), held);
  EXPECT_GT(run.position(29).z(), 0.3);
}

}  // namespace unibody::small_worlds::wind_test
