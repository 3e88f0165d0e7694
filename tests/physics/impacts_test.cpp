// Impacts within a step: what they conserve, and how fast they come to the closed forms as steps get shorter.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "small_worlds.hpp"

namespace unibody::small_worlds::impacts_test {

class Impacts : public testing::TestWithParam<const char*> {};

namespace {

// m, of the first peaks of a body dropped by 1 m that bounces with e = 0.5.
std::vector<double> peaks(const std::string& solver, const std::string& shape, double h) {
  Experiment run(
      scene_from_text("time: {frame: " + std::to_string(h) + "}\nsolver: {name: " + solver +
                      "}\nmaterials: {m: {friction: 0.3, restitution: 0.5}}\nbodies:\n  - {shape: {plane: {normal: [0, 0, "
                      "1]}}}\n  - {shape: {" +
                      shape + "}, mass: 1, position: [0, 0, 1.1]}\n"));
  std::vector<double> result;
  double before = 2, last = 1.5;  // above where it starts
  while (result.size() < 3 && run.simulation->when.steps_done * h < 2) {
    run.step();
    const double z = run.position(1).z() - 0.1;
    if (last >= before && last > z) result.push_back(last);
    before = last, last = z;
  }
  return result;
}

}  // namespace

// Heights e^2, e^4, e^6, sampled: a peak may be missed by g h^2 / 8.
TEST_P(Impacts, PeaksAreOfSecondOrder) {
  for (const char* shape : {"sphere: {radius: 0.1}", "box: {size: [0.2, 0.2, 0.2]}", "cylinder: {radius: 0.3, length: 0.2}"})
    for (const double h : {0.016, 0.008, 0.004}) {
      const std::vector<double> found = peaks(GetParam(), shape, h);
      ASSERT_EQ(found.size(), 3u);
      for (int k = 0; k < 3; ++k)
        EXPECT_NEAR(found[static_cast<std::size_t>(k)], std::pow(0.25, k + 1), 9.81 * h * h / 4 + 1e-9) << shape << ' ' << h;
    }
}

// J = (1 + e) v, w = mu J r / I, as long as it slides: first order in the step before.
TEST_P(Impacts, FrictionGivesTheSpinOfTheImpulse) {
  for (const double h : {0.016, 0.004}) {
    Experiment run(
        scene_from_text("time: {frame: " + std::to_string(h) + "}\nsolver: {name: " + GetParam() +
                        "}\ngravity: [0, 0, 0]\nmaterials: {m: {friction: 0.1, restitution: 0.5}}\nbodies:\n  - {shape: "
                        "{plane: {normal: [0, 0, 1]}}}\n  - {shape: {sphere: {radius: 0.1}}, mass: 1, position: [0, 0, "
                        "0.31], velocity: [2, 0, -2]}\n"));
    run.seconds(0.16);
    EXPECT_NEAR(run.velocity(1).z(), 1, 1e-12);
    EXPECT_NEAR(run.velocity(1).x(), 2 - 0.1 * 1.5 * 2, 1e-12);
    EXPECT_NEAR(run.state(1).angular_velocity.y(), 0.1 * 1.5 * 2 * 0.1 / (0.4 * 0.01), 1e-9);
    EXPECT_NEAR(run.position(1).z(), 0.1 + (0.16 - 0.105), 1e-12);  // it comes at 0.105 s, and goes on from there
  }
}

TEST_P(Impacts, GlancingOnesKeepAngularMomentum) {
  for (const char* shape : {"sphere: {radius: 0.05}", "box: {size: [0.1, 0.1, 0.1]}"})
    for (const double speed : {1.0, 5.0, 50.0})
      for (const double e : {0.0, 0.7}) {
        if (shape[0] == 'b' && speed > 1) continue;  // swept solids that are not round: their arms are of another moment
        Experiment run(scene_from_text("solver: {name: " + std::string(GetParam()) +
                                       "}\ngravity: [0, 0, 0]\nmaterials: {m: {friction: 0.3, restitution: " + std::to_string(e) +
                                       "}}\nbodies:\n  - {shape: {" + shape + "}, mass: 1}\n  - {shape: {" + shape +
                                       "}, mass: 1, position: [" + std::to_string(-0.11 - 0.005 * speed) +
                                       ", 0.07, 0], velocity: [" + std::to_string(speed) + ", 0, 0]}\n"));
        const Vec3 before = run.angular_momentum();
        run.seconds(0.32);
        EXPECT_GT(run.velocity(0).norm(), 0.1 * speed) << shape << ' ' << speed;  // they met
        EXPECT_LT((run.angular_momentum() - before).norm(), 1e-9 * speed) << shape << ' ' << speed << ' ' << e;
        EXPECT_LE(run.kinetic_energy(), 0.5 * speed * speed * (1 + 1e-12)) << shape << ' ' << speed << ' ' << e;
      }
}

// A round body that lands sliding rolls on at v0 / (1 + I / (m r^2)), since friction leaves it its angular momentum about the
// point of contact; wherever in the step it touches, and however it bounces before. A compound ball, a cylinder and a capsule
// ended at up to 2.1 m/s having started at 2, since their contact was held to move along the ground by half of their way.
TEST_P(Impacts, WhatLandsSlidingRollsOn) {
  const double r = 0.08, c = 0.3;  // m; a capsule's volumes are pi r^2 c and 4/3 pi r^3
  const double rod = c, cap = 4.0 / 3 * r;
  const struct {
    const char* shape;
    double inertia;  // about the axis by which it rolls, over m r^2
  } shapes[] = {{"sphere: {radius: 0.08}", 0.4},
                {"compound: {parts: [{shape: {sphere: {radius: 0.08}}, position: [0, 0, 0]}]}", 0.4},
                {"cylinder: {radius: 0.08, length: 0.3}", 0.5},
                {"capsule: {radius: 0.08, length: 0.3}", (0.5 * rod + 0.4 * cap) / (rod + cap)}};
  const char* grounds[] = {"{shape: {plane: {normal: [0, 0, 1]}}}",
                           "{shape: {box: {size: [40, 40, 1]}}, motion: fixed, position: [0, 0, -0.5]}",
                           "{shape: {mesh: {height_field: {size: [40, 40], cells: [1, 1], heights: [0, 0, 0, 0]}}}}"};
  for (const auto& [shape, inertia] : shapes)
    for (const char* ground : grounds)
      for (const double restitution : {0.0, 0.5})
        for (const int substeps : {1, 4}) {
          if (std::string(shape).starts_with("sphere") && restitution == 0) continue;  // off by up to half a gap over its radius
          Experiment run(scene_from_text("time: {substeps: " + std::to_string(substeps) + "}\nsolver: {name: " + GetParam() +
                                         "}\nmaterials: {m: {friction: 0.6, restitution: " + std::to_string(restitution) +
                                         "}}\nbodies:\n  - " + ground + "\n  - {shape: {" + shape +
                                         "}, mass: 1, position: [0.3, 0.2, 0.6], velocity: [2, 0, 0], orientation: {axis: [1, 0, "
                                         "0], angle: 90}}\n"));
          run.seconds(1.6);
          const std::string which = std::string(shape) + " on " + ground + ", e " + std::to_string(restitution);
          EXPECT_NEAR(run.velocity(1).x(), 2 / (1 + inertia), 2e-4) << which;
          EXPECT_NEAR(run.state(1).angular_velocity.y() * r, 2 / (1 + inertia), 2e-4) << which;
        }
}

// A ball without friction meets a free box that spins at some 35 rad/s, half a radian a step, so that the gyroscopic torque
// changes the box's spin within the step. The elastic impact gives no energy, and takes little.
TEST_P(Impacts, ASpinningBoxKeepsItsEnergy) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  const auto vector = [&](double size) { return Vec3(size * normal(random), size * normal(random), size * normal(random)); };
  const auto told = [](const Vec3& v) {
    return "[" + std::to_string(v.x()) + ", " + std::to_string(v.y()) + ", " + std::to_string(v.z()) + "]";
  };
  double squares = 0;
  int hits = 0;
  for (int k = 0; k < 100; ++k) {
    const Vec3 way = vector(1).normalized(), spin = vector(20), from = -0.35 * way + vector(0.03);
    Experiment run(scene_from_text("gravity: [0, 0, 0]\nsolver: {iterations: 200, name: " + std::string(GetParam()) +
                                   "}\nmaterials: {m: {friction: 0, restitution: 1}}\nbodies:\n  - {shape: {box: {size: [0.08, "
                                   "0.12, 0.2]}}, mass: 1, angular_velocity: " +
                                   told(spin) + "}\n  - {shape: {sphere: {radius: 0.06}}, mass: 1, position: " + told(from) +
                                   ", velocity: " + told(4 * way) + "}\n"));
    const double before = run.kinetic_energy();
    const Vec3 momentum = run.momentum();
    run.steps(8);
    const double change = run.kinetic_energy() / before - 1;
    EXPECT_LT(change, 1e-3) << k;
    EXPECT_GT(change, -0.02) << k;
    EXPECT_LT((run.momentum() - momentum).norm(), 1e-12) << k;
    squares += change * change, hits += (run.velocity(0).norm() > 1e-6);
  }
  EXPECT_GT(hits, 80);
  EXPECT_LT(std::sqrt(squares / hits), 3e-3);
}

// A dumb-bell of two boxes, side by side in front of a box that flies at them at 20 m/s, half a box aside, is hit at one end and
// turns its other one against the box within the same step, in 40 ways. No more energy comes out than went in; 42 % did.
TEST_P(Impacts, WhatIsHitTwiceInAStepGainsNoEnergy) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> aside(-0.15, 0.15), turn(-1, 1);
  const auto some = [&](double low, double high) { return std::to_string(low + (high - low) * 0.5 * (1 + turn(random))); };
  const std::string part = "{shape: {box: {size: [0.1, 0.08, 0.12]}}, position: [0, 0, ";
  int hits = 0;
  for (int k = 0; k < 40; ++k) {
    const auto spin = [&] { return "[" + some(-5, 5) + ", " + some(-5, 5) + ", " + some(-5, 5) + "]"; };
    Experiment run(scene_from_text("gravity: [0, 0, 0]\nsolver: {name: " + std::string(GetParam()) +
                                   "}\nmaterials: {m: {friction: 0, restitution: 1}}\nbodies:\n  - {shape: {compound: {parts: [" +
                                   part + "0.07]}, " + part + "-0.07]}]}}, mass: 1, angular_velocity: " + spin() +
                                   "}\n  - {shape: {box: {size: [0.12, 0.13, 0.11]}}, mass: 1, position: [" + some(-0.4, -0.2) +
                                   ", " + some(-0.05, 0.05) + ", " + std::to_string(aside(random)) + "], velocity: [20, " +
                                   some(-2, 2) + ", " + some(-2, 2) + "], angular_velocity: " + spin() + "}\n"));
    const double before = run.kinetic_energy();
    run.steps(3);
    EXPECT_LT(run.kinetic_energy() / before - 1, 1e-4) << k;
    hits += run.velocity(0).norm() > 1e-6;
  }
  EXPECT_GT(hits, 25);
}

// 200 balls in a box of 2 m, 3 m/s, for 10 s.
TEST_P(Impacts, AGasKeepsItsEnergy) {
  std::mt19937 random(5);
  std::normal_distribution<double> speed(0, 2);
  std::string text = "solver: {name: " + std::string(GetParam()) +
                     "}\ngravity: [0, 0, 0]\nmaterials: {m: {friction: 0, restitution: 1}}\nbodies:\n";
  for (int k = 0; k < 6; ++k) {
    const Vec3 n = (k % 2 ? -1.0 : 1.0) * Vec3::Unit(k / 2);
    const auto list = [](const Vec3& x) {
      return "[" + std::to_string(x.x()) + ", " + std::to_string(x.y()) + ", " + std::to_string(x.z()) + "]";
    };
    text += "  - {shape: {plane: {normal: " + list(n) + "}}, position: " + list(-n) + "}\n";
  }
  Scene scene = scene_from_text(text +
                                "  - {shape: {sphere: {radius: 0.05}}, mass: 1, lattice: {count: 200, columns: [6, 6], "
                                "spacing: [0.32, 0.32, 0.32]}, position: [0, 0, -0.85]}\n");
  Experiment run(std::move(scene));
  for (std::size_t i = 0; i < run.world().homes; ++i) run.world().velocity[i] = Vec3(speed(random), speed(random), speed(random));
  const double before = run.kinetic_energy();
  std::int64_t impacts = 0;
  for (int k = 0; k < 625; ++k) {
    run.step(), impacts += run.last.impacts;
    ASSERT_LE(run.kinetic_energy(), before * (1 + 1e-4)) << k;
  }
  EXPECT_GT(impacts, 2000);
  EXPECT_NEAR(run.kinetic_energy() / before, 1, 1e-2);  // from other starts 0 to 0.0016 is lost
  for (std::size_t i = 0; i < run.world().homes; ++i) EXPECT_LT(run.world().position[i].cwiseAbs().maxCoeff(), 1);
}

// 27 bodies of five shapes fly together in disorder and meet in the middle, many at once, without friction and e = 1. Whether
// steps end converged or after 10 iterations, no energy is gained: where a body that parts from another is thrown back against it
// in the step, the bounce that throws it pays for the work of the row that stops it. Steps gained up to 2.4 %.
// (A ten-thousandth is what a body that is hit may gain by turning within the step, solve/free_motion.hpp.)
TEST_P(Impacts, ACrowdNeverGainsEnergy) {
  const char* shapes[] = {"box: {size: [0.2, 0.12, 0.08]}", "capsule: {radius: 0.06, length: 0.1}", "sphere: {radius: 0.08}",
                          "cylinder: {radius: 0.08, length: 0.12}", "box: {size: [0.16, 0.16, 0.16]}"};
  for (const int iterations : {10, 400})
    for (const unsigned seed : {1u, 2u, 3u, 4u, 5u, 6u}) {
      std::mt19937 random(seed);
      std::uniform_real_distribution<double> some(-1, 1);
      std::string text = "gravity: [0, 0, 0]\nsolver: {iterations: " + std::to_string(iterations) + ", name: " + GetParam() +
                         "}\nmaterials: {m: {friction: 0, restitution: 1}}\nbodies:\n";
      for (int k = 0; k < 27; ++k)
        text += "  - {shape: {" + std::string(shapes[random() % 5]) + "}, mass: 1, position: [" +
                std::to_string(0.3 * (k % 3 - 1)) + ", " + std::to_string(0.3 * (k / 3 % 3 - 1)) + ", " +
                std::to_string(0.3 * (k / 9 - 1)) + "]}\n";
      Experiment run(scene_from_text(text));
      for (std::size_t i = 0; i < run.world().homes; ++i) {
        run.world().velocity[i] = -5 * run.world().position[i] + Vec3(some(random), some(random), some(random));
        run.world().angular_velocity[i] = 5 * Vec3(some(random), some(random), some(random));
      }
      const double start = run.kinetic_energy();
      double before = start;
      for (int k = 0; k < 40; ++k) {
        run.step();
        const double now = run.kinetic_energy();
        EXPECT_LT(now / before - 1, run.last.converged ? 5e-4 : 5e-3) << seed << ' ' << iterations << ' ' << k;
        EXPECT_LT(now / start - 1, 1e-4) << seed << ' ' << iterations << ' ' << k;
        before = now;
      }
      EXPECT_GT(before / start, 0.7) << seed << ' ' << iterations;
    }
}

// A row of balls that touch: the last one leaves with the speed of the first.
TEST_P(Impacts, ACradlePassesItOn) {
  std::string text = "solver: {name: " + std::string(GetParam()) +
                     "}\ngravity: [0, 0, 0]\nmaterials: {m: {friction: 0, restitution: 1}}\nbodies:\n";
  for (int k = 0; k < 5; ++k)
    text += "  - {shape: {sphere: {radius: 0.05}}, mass: 1, position: [" + std::to_string(k == 0 ? -0.4 : 0.1 * k) + ", 0, 0]" +
            (k == 0 ? ", velocity: [1, 0, 0]" : "") + "}\n";
  Experiment run(scene_from_text(text));
  run.seconds(0.64);
  for (int k = 0; k < 5; ++k) EXPECT_NEAR(run.velocity(k).x(), k == 4 ? 1 : 0, 1e-9) << k;
}

INSTANTIATE_TEST_SUITE_P(Solvers, Impacts, testing::Values("accelerated_jacobi", "gauss_seidel"));

}  // namespace unibody::small_worlds::impacts_test
