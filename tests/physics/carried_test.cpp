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

std::string number(double x) { return std::to_string(x); }

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

// What lies in the corner of a room that turns, held by its walls alone, goes round with it: its centre stays where it is in the
// room, to a hundredth of its size with 0.13 rad a step, and to a thousandth with a quarter of that. The same holds in a room
// that turns freely.
TEST_P(Carried, InTheCornerOfARoom) {
  const auto [solver, substeps] = GetParam();
  const double place = 0.4, turn = 8, size = 0.2;
  const std::string speed = number(turn * place), at = number(place);
  for (const std::string motion : {"motion: kinematic", "mass: 10000"})
    for (const std::string shape : {"{sphere: {radius: 0.1}}", "{box: {size: [0.2, 0.2, 0.2]}}"}) {
      Experiment run(scene_from_text(
          "gravity: [0, 0, 0]\ntime: {substeps: " + std::to_string(substeps) + "}\nsolver: {name: " + solver +
          "}\nmaterials: {m: {friction: 0}}\nbodies:\n"
          "  - {shape: {compound: {parts: [{shape: {box: {size: [0.1, 1.2, 1]}}, position: [0.55, 0, 0]}, "
          "{shape: {box: {size: [0.1, 1.2, 1]}}, position: [-0.55, 0, 0]}, {shape: {box: {size: [1.2, 0.1, 1]}}, position: [0, "
          "0.55, "
          "0]}, {shape: {box: {size: [1.2, 0.1, 1]}}, position: [0, -0.55, 0]}]}}, " +
          motion + ", position: [0, 0, 0], angular_velocity: [0, 0, 8]}\n  - {shape: " + shape + ", mass: 1, position: [" + at +
          ", " + at + ", 0], velocity: [-" + speed + ", " + speed + ", 0], angular_velocity: [0, 0, 8]}\n"));
      run.seconds(5);
      const Vec3 apart = run.position(1) - run.position(0);
      EXPECT_NEAR(apart.norm(), place * std::sqrt(2), (substeps == 1 ? 1e-2 : 1e-3) * size) << shape << motion;
    }
}

// A body that slides outwards along a blade, without friction: r = r_0 cosh(w t) + (v_0 / w) sinh(w t), and its side stays on the
// blade to second order in the step (that of the turn of the blade's normal, which is taken into account, is the first).
TEST_P(Carried, AlongABlade) {
  const auto [solver, substeps] = GetParam();
  const double turn = 5, from = 0.5, speed = 2, side = 0.15;
  for (const std::string shape : {"{sphere: {radius: 0.1}}", "{box: {size: [0.2, 0.2, 0.2]}}"}) {
    Experiment run(scene_from_text("gravity: [0, 0, 0]\ntime: {substeps: " + std::to_string(substeps) +
                                   "}\nsolver: {name: " + solver +
                                   "}\nmaterials: {m: {friction: 0}}\nbodies:\n"
                                   "  - {shape: {box: {size: [9, 0.1, 0.4]}}, motion: kinematic, angular_velocity: [0, 0, 5]}\n"
                                   "  - {shape: " +
                                   shape + ", mass: 1, position: [0.5, 0.15, 0], velocity: [" + number(speed - turn * side) +
                                   ", " + number(turn * from) + ", 0], angular_velocity: [0, 0, 5]}\n"));
    const double t = 0.32, angle = turn * t;
    run.seconds(t);
    const Vec3 along(std::cos(angle), std::sin(angle), 0), across(-std::sin(angle), std::cos(angle), 0);
    const double right = from * std::cosh(angle) + speed / turn * std::sinh(angle);
    EXPECT_NEAR(run.position(1).dot(along), right, 0.01 * right / substeps) << shape;
    EXPECT_NEAR(run.position(1).dot(across), side, 0.004 / (substeps * substeps)) << shape;
  }
}

// A thread that lies on the inner side of a turning room's wall, along the axis, goes round with the room, as a box of its width
// does. The wall is faster than the thread's centre by w times the thread's radius, which its nodes, that have no turn of their
// own, are not to follow: they would be 0.2 m ahead after 5 s.
TEST_P(Carried, AThreadAtAWall) {
  const auto [solver, substeps] = GetParam();
  for (const bool is_thread : {true, false}) {
    const std::string wall =
        "  - {shape: {compound: {parts: [{shape: {box: {size: [0.1, 1, 1]}}, position: [0.55, 0, 0]}, "
        "{shape: {box: {size: [0.1, 1, 1]}}, position: [-0.55, 0, 0]}]}}, motion: kinematic, position: [0, 0, 0], "
        "angular_velocity: [0, 0, 8]}\n";
    const std::string thread =
        "threads:\n  - {points: [[0, 0, -0.2], [0, 0, 0.2]], position: [0.495, 0, 0], segments: 8, mass: 0.1, radius: 0.005, "
        "velocity: [0, 3.96, 0]}\n";
    const std::string box =
        "  - {shape: {box: {size: [0.01, 0.01, 0.01]}}, mass: 0.1, position: [0.495, 0, 0], velocity: [0, 3.96, 0], "
        "angular_velocity: [0, 0, 8]}\n";
    Experiment run(scene_from_text("gravity: [0, 0, 0]\ntime: {substeps: " + std::to_string(substeps) + "}\nsolver: {name: " +
                                   solver + "}\nmaterials: {m: {friction: 1}}\nbodies:\n" + wall + (is_thread ? thread : box)));
    run.seconds(4.8);
    const double angle = 8 * 4.8;
    const Vec3 along(std::cos(angle), std::sin(angle), 0), across(-std::sin(angle), std::cos(angle), 0);
    for (Id id = 1; id <= (is_thread ? 9 : 1); ++id) {
      EXPECT_NEAR(run.position(id).dot(along), 0.495, substeps == 1 ? 2e-3 : 5e-5) << is_thread << ' ' << id;
      EXPECT_NEAR(run.position(id).dot(across), 0, substeps == 1 ? 1e-3 : 5e-5) << is_thread << ' ' << id;
    }
  }
}

// A body whose motion is given turns by w t, in steps of any length, whether its spin is constant or a function of time.
TEST(DrivenTurn, IsExact) {
  for (const double w : {0.5, 8.0, 40.0})
    for (const std::string& spin : {std::string("angular_velocity: [0, 0, ") + number(w) + "]",
                                    "angular_velocity: {table: [[0, 0, 0, " + number(w) + "], [9, 0, 0, " + number(w) + "]]}"}) {
      Experiment run(scene_from_text("gravity: [0, 0, 0]\nbodies:\n  - {shape: {box: {size: [1, 1, 1]}}, motion: kinematic, " +
                                     spin + "}\n  - {shape: {sphere: {radius: 0.1}}, mass: 1, position: [9, 0, 0]}\n"));
      run.steps(300);
      const Quat turned = run.state(0).orientation;
      EXPECT_NEAR(std::remainder(2 * std::atan2(turned.z(), turned.w()) - w * 4.8, 2 * M_PI), 0, 1e-11) << spin;
      EXPECT_NEAR(run.state(0).angular_velocity.z(), w, 1e-12) << spin;
    }
}

// A box at a wall that gives way, k = 1e4 N/m at each of its corners, is pressed into it by d with 4 k d = m w^2 (r + d).
TEST(CarriedByWhatGivesWay, ABoxAtAWall) {
  const double turn = 8, place = 0.4, right = turn * turn * place / (4e4 - turn * turn);
  for (const char* solver : {"accelerated_jacobi", "gauss_seidel"})
    for (const int substeps : {4, 16}) {
      Experiment run(scene_from_text(
          "gravity: [0, 0, 0]\ntime: {substeps: " + std::to_string(substeps) + "}\nsolver: {name: " + std::string(solver) +
          "}\nmaterials: {m: {friction: 1, stiffness: 1.0e+4, damping_ratio: 0.1}}\nbodies:\n"
          "  - {shape: {compound: {parts: [{shape: {box: {size: [0.1, 1, 1]}}, position: [0.55, 0, 0]}, "
          "{shape: {box: {size: [0.1, 1, 1]}}, position: [-0.55, 0, 0]}]}}, motion: kinematic, "
          "position: [0, 0, 0], angular_velocity: [0, 0, 8]}\n"
          "  - {shape: {box: {size: [0.2, 0.2, 0.2]}}, mass: 1, position: [0.4, 0, 0], velocity: [0, 3.2, "
          "0], angular_velocity: [0, 0, 8]}\n"));
      run.seconds(3.2);
      EXPECT_NEAR(run.position(1).norm() - place, right, 0.04 * right / (substeps / 4)) << solver << ' ' << substeps;
    }
}

// At the wall of a turning drum friction bears what mu w^2 r > g: a rider stays where it is, here by a tenth.
TEST_P(Carried, AtTheWallOfADrum) {
  const auto [solver, substeps] = GetParam();
  constexpr int plates = 48;
  constexpr double turn = 6, radius = 1, place = radius - 0.05;
  std::string parts;
  for (int k = 0; k < plates; ++k) {
    const double a = 2 * M_PI * k / plates, out = radius + 0.05;
    parts += std::string(k > 0 ? ", " : "") + "{shape: {box: {size: [0.1, 0.15, 1]}}, position: [" + number(out * std::cos(a)) +
             ", " + number(out * std::sin(a)) + ", 0], orientation: [" + number(std::cos(a / 2)) + ", 0, 0, " +
             number(std::sin(a / 2)) + "]}";
  }
  Experiment run(scene_from_text(
      "time: {substeps: " + std::to_string(substeps) + "}\nsolver: {name: " + solver + "}\nmaterials: {m: {friction: " +
      number(1.1 * 9.81 / (turn * turn * place)) + "}}\nbodies:\n  - {shape: {compound: {parts: [" + parts +
      "]}}, motion: kinematic, position: [0, 0, 0], angular_velocity: [0, 0, 6]}\n"
      "  - {shape: {box: {size: [0.1, 0.1, 0.1]}}, mass: 1, position: [0.95, 0, 0], velocity: [0, 5.7, 0], "
      "angular_velocity: [0, 0, 6]}\n"));
  run.seconds(5);
  EXPECT_NEAR(distance(run, 1), place, 1e-3);
  EXPECT_NEAR(run.position(1).z(), 0, substeps == 1 ? 0.02 : 1e-3);  // in steps of 0.1 rad it slips now and then
}

INSTANTIATE_TEST_SUITE_P(Solvers, Carried,
                         testing::Combine(testing::Values("accelerated_jacobi", "gauss_seidel"), testing::Values(1, 4)));

}  // namespace unibody::small_worlds::carried_test
