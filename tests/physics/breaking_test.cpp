// Joints and bonds that break, against statics, beams and the momentum of a blow.
#include <gtest/gtest.h>

#include <cmath>

#include "changes/changing.hpp"
#include "joints/strength.hpp"

namespace unibody::small_worlds::breaking_test {

namespace {

constexpr double g = 9.81;

// A solver, and how long its steps are: frames of 10 ms.
struct Way {
  std::string solver, joints;
  int substeps;
  std::string text() const { return solver + ", joints " + joints + ", substeps " + std::to_string(substeps); }
  std::string settings() const {
    return "solver: {name: " + solver + ", joints: " + joints + "}\ntime: {frame: 0.01, substeps: " + std::to_string(substeps) +
           "}\n";
  }
};

std::vector<Way> ways() {
  std::vector<Way> all;
  for (const char* solver : {"accelerated_jacobi", "jacobi", "gauss_seidel"})
    for (const char* joints : {"iterative", "direct"})
      for (const int substeps : {1, 4}) all.push_back({solver, joints, substeps});
  return all;
}

const std::vector<Break>& breaks_of(Experiment& run) {
  run.simulation->detect();
  return run.simulation->history.past.breaks;
}

std::string number(double x) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.17g", x);
  return text.data();
}

// Cubes of 0.1 m and 1 kg in a row from (0, 0, 1) on, and one more before the first, which is fixed.
std::string bar(int cubes, const Vec3& along, const std::string& of_last = "") {
  const auto place = [&](int k) {
    const Vec3 p = Vec3(0, 0, 1) + 0.1 * k * along;
    return "position: [" + number(p.x()) + ", " + number(p.y()) + ", " + number(p.z()) + "]";
  };
  const std::string cube = "shape: {box: {size: [0.1, 0.1, 0.1]}}, ";
  std::string text = "bodies:\n  - {name: wall, " + cube + "motion: fixed, " + place(-1) + "}\n";
  for (int k = 0; k < cubes; ++k)
    text +=
        "  - {name: cube" + std::to_string(k) + ", " + cube + "mass: 1, " + place(k) + (k + 1 == cubes ? of_last : "") + "}\n";
  return text;
}

std::string bonds(int cubes, const std::string& law) {
  std::string names = "wall";
  for (int k = 0; k < cubes; ++k) names += ", cube" + std::to_string(k);
  return "bonds:\n  - {bodies: [" + names + "], " + law + "}\n";
}

}  // namespace

TEST(Breaking, LoadsAddUpAsTheStressesOfABeam) {
  Strength s;
  s.tension = 10, s.bending = 4, s.shear = 5, s.twisting = 2;
  EXPECT_NEAR(load_share(s, {0, 0, 5}, {1.2, 1.6, 0}), 5.0 / 10 + 2.0 / 4, 1e-12);
  EXPECT_NEAR(load_share(s, {0, 0, -5}, {1.2, 1.6, 0}), -5.0 / 10 + 2.0 / 4, 1e-12);
  EXPECT_NEAR(load_share(s, {3, 4, 0}, {0, 0, -1}), 5.0 / 5 + 1.0 / 2, 1e-12);
  s.force = 4, s.torque = 0.5;
  EXPECT_NEAR(load_share(s, {0, 0, -5}, {0, 0, 0}), 5.0 / 4, 1e-12);
  EXPECT_NEAR(load_share(s, {0, 0, 0}, {0.5, 0, 1}), std::hypot(0.5, 1) / 0.5, 1e-12);
}

// Each type of joint carries 2 kg: with 1.03 of their weight it holds, with 0.97 it breaks, and they fall freely from then on.
TEST(Breaking, AJointCarriesItsStrength) {
  const char* const types[] = {"type: ball, anchor: [0, 0, 0.5]",
                               "type: hinge, anchor: [0, 0, 0.5], axis: [0, 1, 0]",
                               "type: slider, anchor: [0, 0, 0.5], axis: [1, 0, 0]",
                               "type: fixed, anchor: [0, 0, 0.5]",
                               "type: universal, anchor: [0, 0, 0.5], axis: [1, 0, 0], second_axis: [0, 1, 0]",
                               "type: rope, points: [[0, 0, 0], [0, 0, 0.5]]",
                               "type: spring, points: [[0, 0, 0], [0, 0, 0.5]]"};
  for (const Way& way : ways())
    for (const std::string type : types)
      for (const double share : {1.03, 0.97}) {
        const std::string of = way.text() + ", " + type + ", " + std::to_string(share);
        Experiment run(scene_from_text("bodies: [{name: load, shape: {box: {size: [0.2, 0.2, 0.2]}}, mass: 2}]\njoints: [{" +
                                       type + ", bodies: [load, world], strength: {force: " + number(share * 2 * g) + "}}]\n" +
                                       way.settings()));
        run.seconds(1);
        const auto& breaks = breaks_of(run);
        if (share > 1) {
          EXPECT_TRUE(breaks.empty()) << of;
          EXPECT_NEAR(run.position(0).z(), 0, 1e-3) << of;
          continue;
        }
        ASSERT_EQ(breaks.size(), 1u) << of;
        EXPECT_NEAR(breaks.front().force, share * 2 * g, 0.03 * 2 * g) << of;
        EXPECT_NEAR(run.velocity(0).z(), -g * (1 - breaks.front().time), 1e-2) << of;
      }
}

// The bond at the wall bears the moment of all cubes, m g (0.05 + 0.15 + ...) m, the others less.
TEST(Breaking, ACantileverBreaksAtItsRoot) {
  const double moment = g * (0.05 + 0.15 + 0.25 + 0.35 + 0.45);
  for (const Way& way : ways())
    for (const double share : {1.03, 0.97}) {
      Experiment run(scene_from_text(bar(5, Vec3::UnitX()) + bonds(5, "strength: {bending: " + number(share * moment) + "}") +
                                     way.settings()));
      run.seconds(0.5);
      const auto& breaks = breaks_of(run);
      ASSERT_EQ(breaks.size(), share > 1 ? 0u : 1u) << way.text();
      if (share > 1) continue;
      EXPECT_EQ(run.scene->joints[static_cast<std::size_t>(breaks[0].joint)].ids[0], 0) << way.text();
    }
}

// Of five cubes that hang from each other the first bond bears most. Once it has broken, they fall and none bears anything.
TEST(Breaking, AHangingBarBreaksAtItsTop) {
  for (const Way& way : ways()) {
    Experiment run(
        scene_from_text(bar(5, -Vec3::UnitZ()) + bonds(5, "strength: {tension: " + number(3.5 * g) + "}") + way.settings()));
    run.seconds(0.5);
    const auto& breaks = breaks_of(run);
    ASSERT_EQ(breaks.size(), 1u) << way.text();
    EXPECT_EQ(run.scene->joints[static_cast<std::size_t>(breaks[0].joint)].ids[0], 0) << way.text();
    for (Id k = 1; k <= 5; ++k) EXPECT_NEAR(run.velocity(k).z(), -g * (0.5 - breaks[0].time), 2e-2) << way.text();
  }
}

TEST(Breaking, PressureBreaksNoBond) {
  for (const Way& way : ways()) {
    Experiment run(
        scene_from_text(bar(5, Vec3::UnitZ()) + bonds(5, "strength: {tension: " + number(0.1 * g) + "}") + way.settings()));
    run.seconds(0.5);
    EXPECT_TRUE(breaks_of(run).empty()) << way.text();
  }
}

// A bar of bonds is a beam: n L F / (E A) longer under a pull F, and bent by n L M / (E I) by a torque M.
TEST(Breaking, ABeamIsAsStiffAsItsModulus) {
  const double modulus = 1e7, radius = 0.03, area = M_PI * radius * radius, second_moment = area * radius * radius / 4;
  const std::string law = "damping: 0.05, beam: {radius: 0.03, youngs_modulus: 1e7}";
  for (const int substeps : {1, 4}) {
    const std::string settings = Way{"accelerated_jacobi", "direct", substeps}.settings() + "gravity: [0, 0, 0]\n";
    Experiment pulled(scene_from_text(bar(5, Vec3::UnitX(), ", force: [100, 0, 0]") + bonds(5, law) + settings));
    Experiment bent(scene_from_text(bar(5, Vec3::UnitX(), ", torque: [0, 0.5, 0]") + bonds(5, law) + settings));
    pulled.seconds(3), bent.seconds(3);
    const double longer = 5 * 0.1 * 100 / (modulus * area), angle = 5 * 0.1 * 0.5 / (modulus * second_moment);
    EXPECT_NEAR(pulled.position(5).x() - 0.4, longer, 1e-4 * longer);
    EXPECT_NEAR(2 * std::asin(bent.state(5).orientation.y()), angle, 1e-3 * angle);
  }
}

// The beam's own strength: with bending alone at M r / I, with a pull alone at F / A.
TEST(Breaking, ABeamBearsItsTensileStrength) {
  const double radius = 0.03, area = M_PI * radius * radius, second_moment = area * radius * radius / 4, strength = 1e5;
  for (const double share : {0.97, 1.03}) {
    const double pull = share * strength * area, torque = share * strength * second_moment / radius;
    for (const std::string& load : {", force: [" + number(pull) + ", 0, 0]", ", torque: [0, " + number(torque) + ", 0]",
                                    ", torque: [" + number(2 * torque) + ", 0, 0]", ", force: [0, " + number(pull) + ", 0]"}) {
      Experiment run(scene_from_text(bar(1, Vec3::UnitX(), load) +
                                     bonds(1, "beam: {radius: 0.03, tensile_strength: 1e5, shear_strength: 1e5}") +
                                     Way{"accelerated_jacobi", "direct", 4}.settings() + "gravity: [0, 0, 0]\n"));
      run.seconds(0.5);
      const bool across = load.find("force: [0, ") != std::string::npos;  // bends the bond as well: 0.05 m from it
      EXPECT_EQ(breaks_of(run).size(), share > 1 || across ? 1u : 0u) << share << load;
    }
  }
}

// A blow of momentum J breaks a bond that bears less than J / duration, in steps of any length.
TEST(Breaking, ABlowCountsByItsMomentum) {
  const double duration = 0.05, momentum = 0.5 * 2;
  for (const char* solver : {"accelerated_jacobi", "gauss_seidel"})
    for (const int substeps : {4, 16, 64})
      for (const double share : {1.1, 0.9}) {
        Experiment run(scene_from_text(
            "gravity: [0, 0, 0]\nmaterials: {smooth: {friction: 0}}\n" + bar(1, Vec3::UnitZ()) +
            "  - {name: ball, shape: {sphere: {radius: 0.05}}, mass: 0.5, position: [-0.3, 0, 1], velocity: [2, 0, 0]}\n" +
            bonds(1, "strength: {shear: " + number(share * momentum / duration) + ", duration: " + number(duration) + "}") +
            Way{solver, "iterative", substeps}.settings()));
        run.seconds(0.5);
        EXPECT_EQ(breaks_of(run).size(), share > 1 ? 0u : 1u) << solver << ' ' << substeps << ' ' << share;
      }
}

// A chain of six that is cut in the middle: three hang on, three fall, with the rows of a tree or each by itself.
TEST(Breaking, ACutChainFallsInTwo) {
  for (const Way& way : ways()) {
    std::string joints = "joints:\n";
    for (int k = 0; k < 6; ++k)
      joints += "  - {name: j" + std::to_string(k) + ", type: ball, bodies: [cube" + std::to_string(k) + ", " +
                (k == 0 ? "world" : "cube" + std::to_string(k - 1)) + "], anchor: [0, 0, " + number(1.05 - 0.1 * k) + "]}\n";
    Changing run(bar(6, -Vec3::UnitZ()) + joints + "events:\n  - {when: {time: 0.1}, do: release, joints: j3}\n" +
                 way.settings());
    run.frames(40);
    ASSERT_EQ(breaks_of(run).size(), 1u);
    EXPECT_EQ(breaks_of(run).front().joint, 3);
    EXPECT_NEAR(breaks_of(run).front().time, 0.1, 1e-12);
    for (Id k = 1; k <= 3; ++k) EXPECT_NEAR(run.position(k).z(), 1 - 0.1 * (static_cast<double>(k) - 1), 1e-3) << way.text() << k;
    for (Id k = 4; k <= 6; ++k) EXPECT_NEAR(run.velocity(k).z(), -g * 0.3, 1e-2) << way.text() << k;
    EXPECT_TRUE(run.simulation->is_tied(2) && !run.simulation->is_tied(6 + 1)) << way.text();
    EXPECT_TRUE(run.simulation->joint_states()[3].broken && !run.simulation->joint_states()[2].broken);
  }
}

// Bonded bodies do not touch; those whose bonds are gone rest on each other.
TEST(Breaking, WhatIsReleasedRestsOnWhatItLiesOn) {
  for (const char* solver : {"accelerated_jacobi", "gauss_seidel"}) {
    Changing run(bar(3, Vec3::UnitZ()) + bonds(3, "name: glue") +
                 "events:\n  - {when: {time: 0.1}, do: release, joints: glue}\nsolver: {name: " + solver +
                 "}\ntime: {frame: 0.01, substeps: 4}\n");
    run.frames(5);
    run.simulation->detect();
    EXPECT_TRUE(run.simulation->contacts.manifolds.empty());
    run.frames(95);
    EXPECT_EQ(breaks_of(run).size(), 3u);
    EXPECT_NEAR(run.normal_force(0, 1), 3 * g, 0.05) << solver;
    for (Id k = 1; k <= 3; ++k) {
      EXPECT_NEAR(run.position(k).z(), 1 + 0.1 * (static_cast<double>(k) - 1), 1e-3) << solver << k;
      EXPECT_FALSE(run.simulation->is_tied(k)) << solver << k;
    }
  }
}

// Two wheels in gear: once the second has come off its axle, the first turns by itself.
TEST(Breaking, AGearThatComesOffItsAxleIsInGearNoMore) {
  const auto wheel = [](const char* name, double x, const char* more) {
    return std::string("  - {name: ") + name + ", shape: {cylinder: {radius: 0.2, length: 0.1}}, mass: 1, position: [" +
           number(x) + ", 0, 0]" + more + "}\n";
  };
  Changing run("gravity: [0, 0, 0]\nbodies:\n" + wheel("a", 0, ", torque: [0, 0, 0.1]") + wheel("b", 1, "") +
               "joints:\n  - {name: first, type: hinge, bodies: [a, world], anchor: [0, 0, 0], axis: [0, 0, 1]}\n"
               "  - {name: second, type: hinge, bodies: [b, world], anchor: [1, 0, 0], axis: [0, 0, 1]}\n"
               "couplings: [{joints: [first, second], ratio: -1}]\n"
               "events: [{when: {time: 0.2}, do: release, joints: second}]\ntime: {frame: 0.01, substeps: 4}\n");
  run.frames(20);
  const double inertia = 0.5 * 1 * 0.04, before = run.state(0).angular_velocity.z();
  EXPECT_NEAR(before, 0.1 / (2 * inertia) * 0.2, 1e-3);
  run.frames(20);
  EXPECT_NEAR(run.state(0).angular_velocity.z() - before, 0.1 / inertia * 0.2, 1e-3);
  EXPECT_NEAR(run.state(1).angular_velocity.z(), -before, 1e-3);
}

// A wall whose bonds break under a ball. In the middle of it, all bodies go to other ranks.
TEST(RanksBreaking, StepsHaveTheSameBits) {
  int ranks = 1;
  MPI_Comm_size(MPI_COMM_WORLD, &ranks);
  for (const std::string solver : {"accelerated_jacobi", "gauss_seidel"})
    for (const std::string joints : {"iterative", "direct"}) {
      const std::string text =
          "bodies:\n  - {name: ground, shape: {box: {size: [4, 1, 0.2]}}, motion: fixed, position: [0, 0, -0.1]}\n"
          "  - {name: bricks, wall: {bricks: 5, courses: 5, gap: 0}, shape: {box: {size: [0.4, 0.2, 0.2]}}, density: 1800}\n"
          "  - {name: ball, shape: {sphere: {radius: 0.2}}, mass: 40, position: [0, -0.6, 0.6], velocity: [0, 8, 0]}\n"
          "bonds: [{bodies: [ground, bricks], strength: {force: 6000, torque: 400}}]\nsolver: {name: " +
          solver + ", joints: " + joints + "}\ntime: {frame: 0.01, substeps: 2}\n";
      Experiment alone(scene_from_text(text)), together(scene_from_text(text), MPI_COMM_WORLD);
      alone.steps(10), together.steps(10);
      std::vector<int> home;
      for (std::size_t i = 0; i < together.world().homes; ++i)
        home.push_back(static_cast<int>(together.world().id[i] / 2) % ranks);
      together.simulation->move_homes(home);
      alone.steps(30), together.steps(30);
      const auto &all = breaks_of(alone), &same = breaks_of(together);
      EXPECT_GT(all.size(), 3u);
      EXPECT_LT(all.size(), alone.scene->joints.size());
      ASSERT_EQ(all.size(), same.size()) << solver << ' ' << joints;
      for (std::size_t k = 0; k < all.size(); ++k) {
        EXPECT_EQ(all[k].joint, same[k].joint) << solver << ' ' << joints << ' ' << k;
        EXPECT_EQ(all[k].time, same[k].time) << solver << ' ' << joints << ' ' << k;
        EXPECT_EQ(all[k].force, same[k].force) << solver << ' ' << joints << ' ' << k;
      }
      const World& world = together.world();
      for (std::size_t i = 0; i < world.homes; ++i)
        EXPECT_EQ(world.position[i], alone.position(world.id[i])) << solver << ' ' << joints << ' ' << world.id[i];
    }
}

}  // namespace unibody::small_worlds::breaking_test
