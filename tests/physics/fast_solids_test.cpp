// Solids that move several of their sizes in a step, and turn, stay on their side of a plane and of walls thinner than they are:
// what they first touch with one end turns them, and their centres and other ends must not go on through it.
#include <gtest/gtest.h>

#include <random>

#include "collide/collide.hpp"
#include "small_worlds.hpp"

namespace unibody::small_worlds::fast_solids_test {

namespace {

const char* const shapes[] = {
    "box: {size: [0.4, 0.02, 0.02]}",
    "box: {size: [0.3, 0.3, 0.01]}",
    "box: {size: [0.1, 0.06, 0.14]}",
    "capsule: {radius: 0.03, length: 0.1}",
    "cylinder: {radius: 0.01, length: 0.4}",
    "hull: {points: [[0, 0, 0], [0.1, 0, 0], [0, 0.1, 0], [0, 0, 0.1]]}",
    "compound: {parts: [{shape: {box: {size: [0.2, 0.04, 0.04]}}}, {shape: {sphere: {radius: 0.05}}, position: [0.1, 0, 0]}]}",
};
constexpr int solids = 49;

// Each by itself, at -speed along z, from anywhere in the two steps before it meets what is at z = 0.
std::string shots(const std::string& target, double speed, double spin, const std::string& solver, unsigned seed) {
  std::mt19937 random(seed);
  const auto uniform = [&](double low, double high) { return std::uniform_real_distribution<double>(low, high)(random); };
  std::normal_distribution<double> normal;
  std::ostringstream text;
  text.precision(17);
  text << "gravity: [0, 0, -9.81]\nsolver: " << solver << "\nbodies:\n  - " << target << "\n";
  for (int i = 0; i < solids; ++i) {
    const Quat q = Quat(normal(random), normal(random), normal(random), normal(random)).normalized();
    const auto turn = [&] { return spin > 0 ? uniform(-spin, spin) : 0.; };
    text << "  - {shape: {" << shapes[i % 7] << "}, mass: 1, position: [" << 3 * (i % 7) << ", " << 3 * (i / 7) << ", "
         << uniform(0.5, 0.5 + 0.032 * speed) << "], velocity: [" << uniform(-3, 3) << ", " << uniform(-3, 3) << ", " << -speed
         << "], orientation: [" << q.w() << ", " << q.x() << ", " << q.y() << ", " << q.z() << "], angular_velocity: [" << turn()
         << ", " << turn() << ", " << turn() << "]}\n";
  }
  return text.str();
}

std::string wall(double thickness) {
  return "{shape: {box: {size: [100, 100, " + std::to_string(thickness) + "]}}, motion: fixed}";
}
const std::string plane_at_0 = "{shape: {plane: {normal: [0, 0, 1]}}}";

class FastSolids : public testing::TestWithParam<const char*> {};

TEST_P(FastSolids, StayOnTheirSideOfAPlaneAndOfThinWalls) {
  unsigned seed = 1;
  for (const std::string& target : {plane_at_0, wall(0.001), wall(0.01), wall(0.05)})
    for (const double spin : {0., 60.})
      for (const double speed : {20., 65., 300.}) {
        Experiment run(scene_from_text(shots(target, speed, spin, GetParam(), seed++)));
        for (int step = 0; step < 10; ++step) {
          run.step();
          for (Id id = 1; id <= solids; ++id)
            ASSERT_GT(run.position(id).z(), 0) << shapes[(id - 1) % 7] << " at " << speed << " m/s, spin " << spin << ", against "
                                               << target << ", step " << step;
        }
      }
}

// A free plate is no wall, but a rod must not go through it either, and momentum is kept.
TEST_P(FastSolids, ARodDoesNotGoThroughAFreePlate) {
  for (const double lean : {20., 45., 70.}) {
    Scene scene = scene_with(0.5);
    scene.gravity = Vec3::Zero();
    scene.solver = scene_from_text(std::string("bodies: [") + plane_at_0 + "]\nsolver: " + GetParam()).solver;
    const Quat turn(Eigen::AngleAxisd(lean * EIGEN_PI / 180, Vec3::UnitY()));
    Body rod = block(1, Vec3(0.4, 0.02, 0.02), Vec3(0, 0, 0.5), turn);
    rod.state.velocity = Vec3(0, 0, -65);
    add(scene, block(20, Vec3(3, 3, 0.004), Vec3::Zero())), add(scene, rod);
    Experiment run(scene);
    const Vec3 before = run.momentum();
    for (int step = 0; step < 6; ++step) {
      run.step();
      EXPECT_LT((run.momentum() - before).norm(), 1e-11 * before.norm()) << lean;
      const BodyState plate = run.state(0);
      EXPECT_GT((plate.orientation.conjugate() * (run.position(1) - plate.position)).z(), 0) << lean << ", step " << step;
    }
  }
}

// A ball at 48 mm a step comes close to a corner of a box that spins, and would touch it in the next step only, as steps a
// hundredth as long show. The plane of their contact was that of the touch to come, and within this step the box's corner came
// through it: what had not been touched was hit, here by 0.1 m/s.
TEST_P(FastSolids, NothingIsHitBeforeItIsTouched) {
  const auto left = [&](int substeps) {
    Experiment run(scene_from_text(
        "gravity: [0, 0, 0]\ntime: {substeps: " + std::to_string(substeps) + "}\nsolver: " + std::string(GetParam()) +
        "\nmaterials: {m: {friction: 0}}\nbodies:\n"
        "  - {shape: {box: {size: [0.1, 0.1, 0.1]}}, mass: 1, orientation: [-0.2504421414, -0.8821725343, -0.2561812957, "
        "0.3056493044], velocity: [0, 9, 0], angular_velocity: [1.286236635, -0.7677045439, -7.858512903]}\n"
        "  - {shape: {sphere: {radius: 0.08}}, mass: 1, position: [-0.18883817, -0.1033339827, -0.06278646797], velocity: "
        "[1.225060907, 12.7984413, 0.2665885576]}\n"));
    for (int k = 0; k < substeps; ++k) run.step();
    return (run.velocity(0) - Vec3(0, 9, 0)).norm();
  };
  EXPECT_LT(left(100), 1e-12);
  EXPECT_LT(left(1), 1e-12);
}

INSTANTIATE_TEST_SUITE_P(Solvers, FastSolids,
                         testing::Values("{name: gauss_seidel, iterations: 50}", "{name: accelerated_jacobi, iterations: 50}"));

// The centre of an upright rod is swept too: it may close what is between its core, a quarter of the rod's thickness across, and
// the wall. One that is slow, or whose centre passes beside the wall, has the contact of its end alone.
TEST(FastSolidsContacts, TheCoreIsAContactWhereTheCentreWouldGoIn) {
  CollideSettings settings;
  const Quat upright(Eigen::AngleAxisd(EIGEN_PI / 2, Vec3::UnitY()));
  const auto contacts = [&](double speed, double x) {
    Scene scene = scene_with(0.5);
    Body fixed = block(1, Vec3(2, 2, 0.05), Vec3::Zero());
    fixed.properties.motion = Motion::fixed;
    Body rod = block(1, Vec3(0.4, 0.02, 0.02), Vec3(x, 0, 0.525), upright);
    rod.state.velocity = Vec3(0, 0, -speed);
    add(scene, fixed), add(scene, rod);
    Experiment run(scene);
    run.simulation->detect();
    return run.simulation->contacts;
  };
  const Contacts fast = contacts(50, 0);
  ASSERT_EQ(fast.manifolds.size(), 2u);
  EXPECT_EQ(fast.manifolds[0].count, 4u);
  ASSERT_EQ(fast.manifolds[1].count, 1u);
  EXPECT_NEAR(fast.points[fast.manifolds[1].first].gap, 0.5 - 0.005, 1e-9);
  EXPECT_NEAR(fast.manifolds[1].time, 0.495 / 50, 1e-9);
  EXPECT_LE(contacts(20, 0).manifolds.size(), 1u);      // 0.32 m: its end alone
  EXPECT_LE(contacts(50, 1.008).manifolds.size(), 1u);  // its end meets the wall's rim, its core goes by
}

}  // namespace

}  // namespace unibody::small_worlds::fast_solids_test
