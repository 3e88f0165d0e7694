// Soft solids against the floor, bodies, cloths and each other, by the mechanics of elementary cases.
#include <gtest/gtest.h>

#include <cmath>

#include "small_worlds.hpp"

namespace unibody::small_worlds::soft_contact_test {

namespace {

constexpr double g = 9.81, density = 1000, young = 2e5;

// Of 2e5 Pa and 1000 kg/m^3, with a skin of 1 cm.
std::string block_of(const std::string& size, const std::string& cells, const std::string& more) {
  return "  - block: {size: " + size + ", cells: " + cells +
         "}\n    density: 1000\n    youngs_modulus: 2.0e5\n    poissons_ratio: 0\n    damping: 0.01\n    thickness: 0.01\n    " +
         more + "\n";
}
std::string cube_of(int cells, const std::string& more) {
  const std::string n = std::to_string(cells);
  return block_of("[0.2, 0.2, 0.2]", "[" + n + ", " + n + ", " + n + "]", more);
}

double height_of(const Experiment& run, Id first, Id count) {  // m, mean of these bodies
  double sum = 0;
  for (Id id = first; id < first + count; ++id) sum += run.position(id).z();
  return sum / static_cast<double>(count);
}

// How much shorter (m) such a cube is under its own weight and a weight on top (N), fixed below: its static equilibrium, to
// round-off.
double shortening(int cells, double load) {
  std::string text = "time: {frame: 1.0e4}\nsolver: {name: newton}\nsolids:\n" + cube_of(cells, "position: [0, 0, 0.1]");
  text += "    pins: [{within: {min: [-1, -1, -0.01], max: [1, 1, 0.01]}}]\n";
  if (load > 0)
    text += "    loads: [{within: {min: [-1, -1, 0.19], max: [1, 1, 0.21]}, force: [0, 0, -" + std::to_string(load) + "]}]\n";
  Experiment run(scene_from_text(text));
  run.step();
  EXPECT_TRUE(run.last.converged);
  const int nodes = (cells + 1) * (cells + 1);
  return 0.2 - height_of(run, nodes * cells, nodes);
}

}  // namespace

// Gravity leans, downhill is +x. Below the angle of friction the block stays, beyond it its momentum grows by g (sin - mu cos).
TEST(SoftContact, ABlockSticksOrSlidesOnASlope) {
  const double mu = 0.4;
  for (const char* solver : {"accelerated_jacobi", "gauss_seidel"})
    for (const double factor : {0.9, 1.1}) {
      const double angle = std::atan(factor * mu);
      Scene scene = scene_from_text("time: {frame: 0.008}\nsolids:\n" +
                                    block_of("[0.3, 0.2, 0.1]", "[2, 2, 1]", "position: [0, 0, 0.055]"));
      scene.gravity = g * Vec3(std::sin(angle), 0, -std::cos(angle)), scene.friction = {mu};
      scene.solver.name = solver, scene.solver.iterations = 100, scene.solver.tolerance = 0;
      add(scene, ground());
      Experiment run(std::move(scene));
      const double mass = density * 0.3 * 0.2 * 0.1;
      run.steps(20);  // the first ones press it flat
      const double before = run.momentum().x() / mass, x = run.position(0).x();
      run.steps(60);
      if (factor < 1) {
        EXPECT_LT(std::abs(run.position(0).x() - x), 1e-4) << solver;  // free of friction it would be 0.4 m
        EXPECT_LT(std::abs(run.momentum().x() / mass), 1e-4) << solver;
      } else {
        const double gained = g * (std::sin(angle) - mu * std::cos(angle)) * 60 * run.h();
        EXPECT_NEAR(run.momentum().x() / mass - before, gained, 1e-4 * gained) << solver;
        EXPECT_GE(run.last.sliding, 9) << solver;
      }
      EXPECT_NEAR(run.position(0).z(), 0.005, 1e-4) << solver;
    }
}

// Two blocks of unlike meshes on each other, on a floor or on a pinned sheet: at rest a skin's half or two halves apart, each
// pressed by all that is above it.
TEST(SoftContact, BlocksRestOnEachOtherAndBearTheirWeight) {
  for (const std::string solver : {"accelerated_jacobi", "gauss_seidel"})
    for (const bool on_sheet : {false, true}) {
      const bool slow = solver == "gauss_seidel";  // its far modes are still 1 to 2 % from solved
      if (slow && on_sheet) continue;
      const std::string sheet =
          "cloths:\n  - grid: {size: [0.5, 0.5], nodes: [3, 3]}\n    mass: 1\n    thickness: 0.01\n    position: [0, 0, -0.005]\n"
          "    pins: [{within: {min: [-1, -1, -1], max: [1, 1, 1]}}]\n";
      Scene scene = scene_from_text("time: {frame: 0.008}\n" + (on_sheet ? sheet : "") + "solids:\n" +
                                    cube_of(2, "position: [0, 0, 0.106]") + cube_of(3, "position: [0, 0, 0.317]"));
      scene.solver.name = solver, scene.solver.iterations = slow ? 200 : 100, scene.solver.tolerance = 0;
      const Id lower = on_sheet ? 9 : 0, upper = lower + 27;
      if (!on_sheet) add(scene, ground());
      Experiment run(std::move(scene));
      run.steps(60);
      const double foot = height_of(run, lower, 9), head = height_of(run, lower + 18, 9);
      const double foot_above = height_of(run, upper, 16), head_above = height_of(run, upper + 48, 16);
      const double below = shortening(2, density * g * 0.2 * 0.04), above = shortening(3, 0);
      EXPECT_NEAR(foot, 0.005, 2e-5) << solver << ' ' << on_sheet;
      EXPECT_NEAR(foot_above - head, 0.01, 2e-5) << solver << ' ' << on_sheet;
      EXPECT_NEAR(0.2 - (head - foot), below, (slow ? 0.03 : 0.01) * below) << solver << ' ' << on_sheet;
      EXPECT_NEAR(0.2 - (head_above - foot_above), above, (slow ? 0.03 : 0.01) * above) << solver << ' ' << on_sheet;
      EXPECT_LT(run.kinetic_energy(), 1e-4) << solver << ' ' << on_sheet;
    }
}

// No gravity: whatever hits the block, what the one loses the other gains, to round-off.
TEST(SoftContact, ImpactsInFreeFlightKeepMomentum) {
  const std::string motion = "velocity: [0.2, 0.1, -2]";
  for (const char* solver : {"accelerated_jacobi", "gauss_seidel"})
    for (const std::string other : {"ball", "box", "cloth", "block"}) {
      std::string text = "gravity: [0, 0, 0]\ntime: {frame: 0.008}\n";
      if (other == "cloth")
        text +=
            "cloths:\n  - grid: {size: [0.5, 0.5], nodes: [4, 4]}\n    mass: 1\n    thickness: 0.01\n"
            "    position: [0, 0, 0.12]\n    " +
            motion + "\n";
      text += "solids:\n" + cube_of(2, "position: [0, 0, 0]");
      if (other == "block") text += cube_of(3, "position: [0, 0, 0.23]\n    " + motion);
      Scene scene = scene_from_text(text);
      scene.solver.name = solver;
      Body body = other == "ball" ? ball(3, 0.1, Vec3(0.03, 0.02, 0.23)) : block(3, Vec3(0.1, 0.12, 0.1), Vec3(0.03, 0.02, 0.19));
      body.state.velocity = Vec3(0.2, 0.1, -2), body.state.angular_velocity = Vec3(0, 1, 2);
      if (other == "ball" || other == "box") add(scene, body);
      Experiment run(std::move(scene));
      const Id first = other == "cloth" ? 16 : 0;  // of the block that is hit
      const Vec3 momentum = run.momentum();
      const double energy = run.kinetic_energy();
      for (int k = 0; k < 30; ++k) {
        run.step();
        ASSERT_LT((run.momentum() - momentum).norm(), 1e-13 * momentum.norm()) << solver << ' ' << other << ' ' << k;
      }
      double gained = 0;
      for (Id id = first; id < first + 27; ++id) gained += run.world().properties[run.slot(id)].mass * run.velocity(id).z();
      EXPECT_LT(gained, -1) << solver << ' ' << other << ": it has met nothing";  // kg m/s
      EXPECT_LT(run.kinetic_energy(), energy) << solver << ' ' << other;
    }
}

}  // namespace unibody::small_worlds::soft_contact_test
