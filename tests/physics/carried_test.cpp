// What lies on a turning body is carried along: its distance from the axis stays, over a minute.
#include <gtest/gtest.h>

#include <cmath>

#include "small_worlds.hpp"

namespace unibody::small_worlds::carried_test {

namespace {

std::string head(const std::string& solver, int substeps) {
  return "time: {substeps: " + std::to_string(substeps) + "}\nsolver: {name: " + solver +
         "}\nmaterials: {m: {friction: 0.5}, ice: {friction: 0}}\nbodies:\n";
}

// Two bodies that lie on the turntable. To stay on their circles they need centripetal accelerations w^2 r of 2 and 3.2 m/s^2,
// and friction can give mu g = 4.9 m/s^2.
const std::string riders =
    "  - {shape: {box: {size: [0.1, 0.1, 0.1]}}, mass: 1, position: [0.5, 0, 0.05], velocity: [0, 1, 0], angular_velocity: [0, "
    "0, 2]}\n"
    "  - {shape: {cylinder: {radius: 0.1, length: 0.04}}, mass: 1, position: [-0.8, 0, 0.02], velocity: [0, -1.6, 0], "
    "angular_velocity: [0, 0, 2]}\n";

double distance(const Experiment& run, Id id) { return std::hypot(run.position(id).x(), run.position(id).y()); }

}  // namespace

class Carried : public testing::TestWithParam<std::tuple<const char*, int>> {};

TEST_P(Carried, OnATurntable) {
  const auto [solver, substeps] = GetParam();
  Experiment run(scene_from_text(head(solver, substeps) +
                                 "  - {shape: {cylinder: {radius: 3, length: 0.1}}, motion: kinematic, position: [0, 0, -0.05], "
                                 "angular_velocity: [0, 0, 2]}\n" +
                                 riders));
  run.seconds(60);
  EXPECT_NEAR(distance(run, 1), 0.5, 1e-4);
  EXPECT_NEAR(distance(run, 2), 0.8, 5e-4);
  const double angle = std::atan2(run.position(1).y(), run.position(1).x());  // carried along, not left behind
  EXPECT_NEAR(std::remainder(angle - 120, 2 * M_PI), 0, 0.02);
}

// A heavy disc on ice that turns freely carries a box as a driven one does.
TEST_P(Carried, OnADiscThatIsFree) {
  const auto [solver, substeps] = GetParam();
  Experiment run(
      scene_from_text(head(solver, substeps) +
                      "  - {shape: {plane: {normal: [0, 0, 1]}}, position: [0, 0, -0.1], material: ice}\n"
                      "  - {shape: {cylinder: {radius: 3, length: 0.1}}, mass: 100000, position: [0, 0, -0.05], "
                      "angular_velocity: [0, 0, 2], material: m}\n"
                      "  - {shape: {box: {size: [0.1, 0.1, 0.1]}}, mass: 1, position: [0.5, 0, 0.05], velocity: [0, 1, 0], "
                      "angular_velocity: [0, 0, 2], material: m}\n"));
  run.seconds(20);
  EXPECT_NEAR((run.position(2) - run.position(1)).head<2>().norm(), 0.5, 3e-4);
}

// A body that slides is not drawn inwards: on a table that turns under it, held by nothing, friction pushes along the surface's
// velocity where it is. mu g = 0.0981 m/s^2 is too little to carry it.
TEST_P(Carried, NotWhatSlides) {
  const auto [solver, substeps] = GetParam();
  Experiment run(scene_from_text("time: {substeps: " + std::to_string(substeps) + "}\nsolver: {name: " + solver +
                                 "}\nmaterials: {m: {friction: 0.01}}\nbodies:\n"
                                 "  - {shape: {cylinder: {radius: 3, length: 0.1}}, motion: kinematic, position: [0, 0, -0.05], "
                                 "angular_velocity: [0, 0, 2]}\n"
                                 "  - {shape: {box: {size: [0.02, 0.02, 0.02]}}, mass: 1, position: [0.5, 0, 0.01]}\n"));
  const double t = 0.16;
  run.seconds(t);
  EXPECT_NEAR(run.velocity(1).y(), 0.0981 * t, 2e-5);
  EXPECT_NEAR(run.velocity(1).x(), 0, 1e-4);
}

INSTANTIATE_TEST_SUITE_P(Solvers, Carried,
                         testing::Combine(testing::Values("accelerated_jacobi", "gauss_seidel"), testing::Values(1, 4)));

}  // namespace unibody::small_worlds::carried_test
