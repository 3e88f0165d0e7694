// Small classics with closed forms: piles of discs that stand or fall by friction alone, a top.
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "small_worlds.hpp"

namespace unibody::small_worlds::catalogue_test {

namespace {

// Discs of a planar scene or spheres.
std::string round_world(bool planar, double friction, const char* bodies) {
  return std::string(planar ? "planar: true\n" : "") + "materials: {a: {friction: " + std::to_string(friction) + R"(}}
bodies:
  - {shape: {plane: {normal: [0, 0, 1]}}}
  - {)" + bodies +
         ", shape: {" + (planar ? "disc" : "sphere") + R"(: {radius: 0.1}}, mass: 2}
solver: {iterations: 400, tolerance: 0}
time: {frame: 0.004}
)";
}

}  // namespace

// Five of them on each other stand, and each bears the weight of those above.
TEST(Catalogue, FiveDiscsOrSpheresStandOnEachOther) {
  for (const bool planar : {true, false}) {
    Experiment run(scene_from_text(round_world(planar, 0.5, "stack: {count: 5}")));
    run.seconds(2);
    for (int k = 1; k <= 5; ++k) {
      EXPECT_LT((run.position(k) - Vec3(0, 0, 0.2 * k - 0.1)).norm(), 1e-5) << planar << ' ' << k;
      EXPECT_NEAR(run.normal_force(k - 1, k), (6 - k) * 2 * 9.81, 0.01) << planar << ' ' << k;
    }
  }
}

// Two side by side and a third on them. With N and F = mu N between the third and the others, torques balance where the ground's
// friction is F too, forces where F (1 + cos 30) = N sin 30: it stands above mu = tan 15 degrees = .268, and falls below.
TEST(Catalogue, APyramidStandsByFriction) {
  for (const bool planar : {true, false})
    for (const double mu : {0.25, 0.29}) {
      Experiment run(
          scene_from_text(round_world(planar, mu, "points: [[-0.1, 0, 0.1], [0.1, 0, 0.1], [0, 0, 0.27320508075688772]]")));
      run.seconds(1.5);
      if (mu > std::tan(M_PI / 12))
        EXPECT_NEAR(run.position(3).z(), 0.27320508075688772, 1e-4) << planar << ' ' << mu;
      else
        EXPECT_LT(run.position(3).z(), 0.11) << planar << ' ' << mu;
    }
}

// A top held at a point of its horizontal axis, at d from its centre: it precesses at m g d / (I_3 w), whatever else it weighs.
TEST(Catalogue, ATopPrecesses) {
  const double spin = 150, d = 0.2, rate = 9.81 * d / (0.5 * 0.1 * 0.1 * spin);
  const auto after =
      [&](double h) {
        Experiment run(scene_from_text(R"(
bodies:
  - {name: top, shape: {cylinder: {radius: 0.1, length: 0.04}}, mass: 1, position: [0.2, 0, 0], orientation: {axis: [0, 1, 0], angle: 90}}
joints: [{type: ball, bodies: [top, world], anchor: [0, 0, 0]}]
solver: {iterations: 100, tolerance: 0}
time: {frame: )" + std::to_string(h) + "}\n"));
        run.world().angular_velocity[0] = Vec3(spin, 0, rate), run.world().velocity[0] = Vec3(0, d * rate, 0);
        run.seconds(0.3);
        EXPECT_LT(std::abs(run.position(0).z()), 0.05 * d) << h << ": it does not fall";
        return std::atan2(run.position(0).y(), run.position(0).x());
      };
  const double coarse = after(0.001) / (0.3 * rate) - 1, fine = after(0.00025) / (0.3 * rate) - 1;
  EXPECT_LT(std::abs(fine), 0.005);
  EXPECT_LT(std::abs(fine), std::abs(coarse) / 2) << coarse;
}

}  // namespace unibody::small_worlds::catalogue_test
