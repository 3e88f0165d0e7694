// A scene made smaller in all its lengths by s does the same in times shorter by the root of s: what of the settings is a length
// or a speed must go with the bodies. Powers of two keep every digit, so that any length left behind shows in the last bit.
#include <gtest/gtest.h>

#include <cmath>

#include "small_worlds.hpp"

namespace unibody::small_worlds::scale_test {

namespace {

std::string number(double x) {
  std::ostringstream text;
  text.precision(17);
  text << x;
  return text.str();
}

// Balls and boxes of 5 to 8 mm times s that fall on each other and on boxes that overlap at the start.
std::string grains(double s) {
  const auto length = [s](double metres) { return number(s * metres); };
  return "time: {frame: " + number(0.004 * std::sqrt(s)) + "}\nbodies:\n  - shape: {plane: {normal: [0, 0, 1]}}\n" +
         "  - lattice: {count: 36, columns: [3, 3], spacing: [" + length(0.006) + ", " + length(0.009) + ", " + length(0.009) +
         "], height: " + length(0.006) + ", jitter: " + length(0.0005) + ", rotation_jitter: 0.1}\n" +
         "    shape: {box: {size: [" + length(0.008) + ", " + length(0.008) + ", " + length(0.006) + "]}}\n    density: 2600\n" +
         "  - lattice: {count: 60, columns: [4, 4], spacing: [" + length(0.006) + ", " + length(0.006) + ", " + length(0.006) +
         "], height: " + length(0.045) + ", jitter: " + length(0.0004) + "}\n" +
         "    shape: {sphere: {radius: " + length(0.0025) + "}}\n    density: 2600\n";
}

// A sheet 2 mm times s thick that falls over a ball.
std::string sheet(double s) {
  const auto length = [s](double metres) { return number(s * metres); };
  return "time: {frame: " + number(0.002 * std::sqrt(s)) + "}\nbodies:\n  - {shape: {sphere: {radius: " + length(0.02) +
         "}}, motion: fixed}\ncloths:\n  - grid: {size: [" + length(0.06) + ", " + length(0.06) + "], nodes: [13, 13]}\n" +
         "    mass: " + number(0.001 * s * s * s) + "\n    thickness: " + length(0.002) + "\n    self_collision: true\n" +
         "    position: [0, " + length(0.001) + ", " + length(0.025) + "]\n";
}

}  // namespace

TEST(Scale, ASmallSceneDoesWhatTheLargeOneDoes) {
  const double s = 1.0 / 1024, t = std::sqrt(s);
  for (const std::string solver : {"accelerated_jacobi", "gauss_seidel"})
    for (const auto& text : {grains, sheet}) {
      const std::string settings = "solver: {name: " + solver + "}\n";
      Experiment large(scene_from_text(text(1) + settings)), small(scene_from_text(text(s) + settings));
      const SolverSettings of_large = large.simulation->settings_used(), of_small = small.simulation->settings_used();
      EXPECT_EQ(of_small.tolerance, s * *of_large.tolerance);
      EXPECT_EQ(of_small.margin, s * *of_large.margin);
      EXPECT_EQ(of_small.recovery_speed, t * *of_large.recovery_speed);
      std::size_t most = 0;
      for (int k = 0; k < 150; ++k) {
        const StepReport a = large.step(), b = small.step();
        ASSERT_EQ(a.iterations, b.iterations) << solver << ", step " << k;
        ASSERT_EQ(a.residual * s, b.residual) << solver << ", step " << k;
        ASSERT_EQ(large.penetration() * s, small.penetration()) << solver << ", step " << k;
        ASSERT_EQ(large.simulation->contacts.points.size(), small.simulation->contacts.points.size());
        ASSERT_EQ(large.simulation->contacts.surface.size(), small.simulation->contacts.surface.size());
        most = std::max(most, large.simulation->contacts.points.size() + large.simulation->contacts.surface.size());
        for (std::size_t i = 0; i < large.world().homes; ++i) {
          ASSERT_EQ(large.world().position[i] * s, small.world().position[i]) << solver << ", step " << k << ", body " << i;
          ASSERT_EQ(large.world().velocity[i] * t, small.world().velocity[i]) << solver << ", step " << k << ", body " << i;
        }
      }
      EXPECT_GT(most, 20u) << "nothing has met";
    }
}

// Boxes, cloths and grains of a centimetre or more have 2 mm and 0.25 m/s, without gravity too.
TEST(Scale, LargeBodiesHaveTheLargestMargin) {
  for (const double size : {0.01, 0.12, 20.0})
    for (const double g : {0.0, 9.81}) {
      Scene scene = scene_with(0.5);
      scene.gravity = Vec3(0, 0, -g);
      add(scene, block(1, Vec3(3 * size, size, 2 * size), Vec3(0, 0, 0)));
      add(scene, ground(Vec3(0, 0, -2 * size)));
      const Experiment run(std::move(scene));
      EXPECT_EQ(run.simulation->settings_used().margin, 0.002) << size;
      EXPECT_EQ(run.simulation->settings_used().recovery_speed, 0.25) << size;
    }
}

// What a scene says itself is not touched.
TEST(Scale, SettingsOfTheSceneHold) {
  Scene scene = scene_with(0.5);
  scene.solver.margin = 0.003, scene.solver.recovery_speed = 0;
  add(scene, ball(1, 1e-4, Vec3::Zero()));
  const Experiment run(std::move(scene));
  EXPECT_EQ(run.simulation->settings_used().margin, 0.003);
  EXPECT_EQ(run.simulation->settings_used().recovery_speed, 0);
}

}  // namespace unibody::small_worlds::scale_test
