// What no solver may change: momentum of a closed system, the independence of mass, bounds on energy and on speeds.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "collide/bodies.hpp"
#include "small_worlds.hpp"

namespace unibody::small_worlds::invariants_test {

namespace {

// Boxes and spheres of mixed masses that fly at each other and spin, without gravity and ground.
Scene cluster(double mass_factor = 1) {
  Scene scene = scene_with(0.5);
  scene.gravity = Vec3::Zero();
  unibody::samples::Random random(17);
  for (int k = 0; k < 27; ++k) {
    const Vec3 at = 0.26 * Vec3(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1) + random.vector(-.01, .01);
    const double mass = std::pow(10, random(-1, 1)) * mass_factor;
    Body b = k % 2 ? ball(mass, 0.1, at) : block(mass, Vec3(.18, .14, .2), at, random.turn());
    b.state.velocity = -6 * at + random.vector(-.5, .5);
    b.state.angular_velocity = random.vector(-5, 5);
    add(scene, b);
  }
  return scene;
}

struct Total {
  double linear = 0, angular = 0;  // sums of magnitudes: the scale of round-off
};
Total total(const Experiment& run) {
  Total t;
  const World& w = run.simulation->world;
  for (std::size_t i = 0; i < w.homes; ++i) {
    t.linear += w.properties[i].mass * w.velocity[i].norm();
    t.angular += w.properties[i].mass * w.position[i].norm() * w.velocity[i].norm() +
                 w.properties[i].inertia.maxCoeff() * w.angular_velocity_of(i).norm();
  }
  return t;
}

}  // namespace

TEST(Invariants, MomentumOfAClosedSystem) {
  for (const std::string solver : {"accelerated_jacobi", "jacobi", "gauss_seidel"}) {
    Scene scene = cluster();
    scene.solver.name = solver, scene.solver.iterations = 10;
    Experiment run(scene);
    Vec3 p = run.momentum(), L = run.angular_momentum();
    const double energy = run.kinetic_energy();
    std::size_t contacts = 0;
    for (int k = 0; k < 120; ++k) {
      const Total before = total(run);
      run.step();
      contacts += run.simulation->history.contacts().points.size();
      ASSERT_LT((run.momentum() - p).norm(), 1e-12 * before.linear) << solver << ", step " << k;
      ASSERT_LT((run.angular_momentum() - L).norm(), 1e-12 * before.angular) << solver << ", step " << k;
      p = run.momentum(), L = run.angular_momentum();
    }
    EXPECT_GT(contacts, 100u) << "nothing collided";
    EXPECT_LT(run.kinetic_energy(), 0.9 * energy) << "impacts without restitution cost energy";
  }
}

namespace {

std::vector<BodyState> states_after(const Scene& scene, int steps) {
  Experiment run(scene);
  run.steps(steps);
  std::vector<BodyState> states;
  for (Id id = 0; id < scene.body_count(); ++id) states.push_back(run.state(id));
  return states;
}

// The cluster falls on a ground.
Scene falling(double mass_factor, const std::string& solver) {
  Scene scene = cluster(mass_factor);
  scene.solver.name = solver, scene.solver.iterations = 10;
  scene.gravity = Vec3(0, 0, -9.81);
  add(scene, ground(Vec3(0, 0, -0.5)));
  return scene;
}

}  // namespace

TEST(Invariants, MassesTimesAPowerOfTwoChangeNoBit) {
  for (const std::string solver : {"accelerated_jacobi", "jacobi", "gauss_seidel"}) {
    const auto one = states_after(falling(1, solver), 60);
    for (const double factor : {1024.0, 1 / 1024.0}) {
      const auto other = states_after(falling(factor, solver), 60);
      for (std::size_t i = 0; i < one.size(); ++i) {
        EXPECT_EQ(one[i].position, other[i].position) << solver << ", body " << i;
        EXPECT_EQ(one[i].velocity, other[i].velocity) << solver << ", body " << i;
        EXPECT_EQ(one[i].orientation.coeffs(), other[i].orientation.coeffs()) << solver << ", body " << i;
        EXPECT_EQ(one[i].angular_velocity, other[i].angular_velocity) << solver << ", body " << i;
      }
    }
  }
}

// Times 1000 the last bits differ: after ten steps of collisions still not by more than round-off times a growth of 10 a step.
TEST(Invariants, MassesTimesAThousandChangeOnlyRoundOff) {
  const auto one = states_after(falling(1, "gauss_seidel"), 10), other = states_after(falling(1000, "gauss_seidel"), 10);
  for (std::size_t i = 0; i < one.size(); ++i) EXPECT_LT((one[i].position - other[i].position).norm(), 1e-16 * 1e10);
}

// Painleve's rod: with friction above 4/3 its tip can jam. Whatever the solver finds is finite, and over the whole run no energy
// comes from nowhere: it never rises above the least so far by more than taking out what penetration there is lifts the rod, and
// what the tolerance leaves of an impact, the rod's momentum times an error of speed.
TEST(Invariants, PainlevesRod) {
  for (const std::string solver : {"accelerated_jacobi", "jacobi", "gauss_seidel"})
    for (const double mu : {1.2, 1.5, 3.0})
      for (const bool planar : {true, false})
        for (const double speed : {5.0, -5.0}) {
          const double angle = std::atan(2), length = 1, width = planar ? 0.02 : 0.1;
          Scene scene = scene_with(mu);
          scene.planar = planar;
          scene.solver.name = solver;
          const Quat turn(Eigen::AngleAxisd(-angle, Vec3::UnitY()));  // x axis of the rod up and to the right
          const double height = 0.5 * length * std::sin(angle) + 0.5 * width * std::cos(angle);
          Body rod = block(1, Vec3(length, width, width), Vec3(0, 0, height), turn);
          rod.state.velocity = Vec3(speed, 0, 0);
          add(scene, rod);
          add(scene, ground());
          Experiment run(scene);
          const double start = run.energy(),
                       unsolved = 1 * std::abs(speed) * run.simulation->settings_used().tolerance.value() / run.h();
          double least = start, deepest = 0;
          for (int k = 0; k < 300; ++k) {
            const StepReport report = run.step();
            ASSERT_TRUE(run.finite());
            ASSERT_TRUE(std::isfinite(report.residual));
            ASSERT_LE(run.energy(), least + unsolved + 1 * 9.81 * deepest)
                << solver << ", mu " << mu << (planar ? ", planar" : "") << ", step " << k;
            least = std::min(least, run.energy()), deepest = std::max(deepest, run.penetration());
          }
          EXPECT_LT(run.energy(), 0.9 * start);
        }
}

// Two boxes half inside each other come apart, no faster than the bound on recovery.
TEST(Invariants, DeepOverlapOfAPair) {
  Scene scene = scene_with(0.5);
  scene.gravity = Vec3::Zero();
  add(scene, block(1, Vec3(0.2, 0.2, 0.2), Vec3(0, 0, 0)));
  add(scene, block(1, Vec3(0.2, 0.2, 0.2), Vec3(0.1, 0, 0)));
  Experiment run(scene);
  double fastest = 0;
  for (int k = 0; k < 120; ++k) {
    run.step();
    fastest = std::max({fastest, run.velocity(0).norm(), run.velocity(1).norm()});
  }
  EXPECT_LT(run.penetration(), 1e-4);
  const double bound = 0.25 + run.simulation->settings_used().tolerance.value() / run.h();  // the solver stops at this residual
  EXPECT_LE((run.velocity(0) - run.velocity(1)).norm(), bound);
  EXPECT_LE(fastest, bound);
  EXPECT_GT((run.position(1) - run.position(0)).norm(), 0.199);
}

// An overlap of 1 mm is left at d / (h + T), T one frame: hardly faster in finer steps.
TEST(Invariants, FinerStepsTakeOverlapOutNoFaster) {
  const double depth = 1e-3, frame = 0.016;
  for (const int substeps : {1, 4, 64}) {
    Scene scene = scene_with(0.5);
    scene.gravity = Vec3::Zero();
    scene.time.frame = frame, scene.time.substeps = substeps, scene.solver.tolerance = 0;
    add(scene, ball(1, 0.1, Vec3(0, 0, 0)));
    add(scene, ball(1, 0.1, Vec3(0.2 - depth, 0, 0)));
    Experiment run(scene);
    run.steps(substeps);
    EXPECT_NEAR((run.velocity(1) - run.velocity(0)).x(), depth / (frame / substeps + frame), 1e-9) << substeps;
  }
}

// A lattice at half the spacing that its boxes need: 13 layers, each inside the next. The layers' speeds add up, no more: at the
// default bound on recovery, and at the one for unknown input.
TEST(Invariants, DeepOverlapOfALattice) {
  for (const auto& [solver, bound] : {std::pair<std::string, double>{"gauss_seidel", 0.25},
                                      {"accelerated_jacobi", 0.25},
                                      {"gauss_seidel", 0.1},
                                      {"accelerated_jacobi", 0.1}}) {
    Experiment run(scene_from_text(R"(
bodies:
  - shape: {plane: {normal: [0, 0, 1]}}
  - lattice: {count: 208, columns: [4, 4], spacing: [0.08, 0.08, 0.095], height: 0.1, jitter: 0.005, rotation_jitter: 0.05}
    shape: {box: {size: [0.12, 0.12, 0.15]}}
    mass: 1
solver: {iterations: 30, name: )" + solver +
                                   (bound == 0.1 ? ", recovery_speed: 0.1}\n" : "}\n")));
    ASSERT_EQ(run.simulation->settings_used().recovery_speed, bound);
    const double start_height = 0.1 + 12 * 0.095, layers = 13;
    double fastest = 0, highest = 0;
    for (int k = 0; k < 200; ++k) {
      run.step();
      ASSERT_TRUE(run.finite());
      for (std::size_t i = 0; i < run.world().homes; ++i) {
        fastest = std::max(fastest, run.world().velocity[i].norm());
        highest = std::max(highest, run.world().position[i].z());
      }
    }
    // Ejected at the bound a layer, or fallen from the height that twice the spacing gives.
    EXPECT_LT(fastest, bound * layers + std::sqrt(2 * 9.81 * 2 * start_height)) << solver << bound;
    EXPECT_LT(highest, 2 * start_height + 0.15) << solver;
    EXPECT_LT(run.kinetic_energy() / 208, 0.02) << solver;
    // 3.2 s at 0.1 m/s part every pair three times over; solvers that leak nothing where contacts open hand the motion on from
    // layer to layer more slowly: five times as long.
    run.steps(800);
    EXPECT_LT(run.penetration(), 0.002) << solver << bound;
    EXPECT_LT(run.kinetic_energy() / 208, 0.02) << solver << bound;
  }
}

// Whose inertia about their length is a thousandth to a hundred thousandth of that across: what a step turns wrongly must not
// spin them up.
TEST(Invariants, ThinRodsThatLandGainNoEnergy) {
  for (const std::string solver : {"accelerated_jacobi", "gauss_seidel"})
    for (const double width : {0.003, 0.01, 0.02, 0.05})
      for (int c = 0; c < 10; ++c) {
        Scene scene = scene_with(c % 2 ? 1 : 0.3);
        scene.solver.name = solver;
        const Quat turn = Quat(Eigen::AngleAxisd(0.3 + 0.2 * c, Vec3::UnitZ())) *
                          Quat(Eigen::AngleAxisd(-0.2 - 0.1 * c, Vec3::UnitY())) *
                          Quat(Eigen::AngleAxisd(0.26 * c, Vec3::UnitX()));
        Body rod = block(1, Vec3(1, width, width), Vec3(0, 0, 0.8), turn);
        rod.state.velocity = Vec3(3, 0, 0);
        add(scene, rod), add(scene, ground());
        Experiment run(scene);
        const double energy = run.energy();
        for (int k = 0; k < 190; ++k) {
          run.step();
          ASSERT_LT(run.energy(), energy) << solver << ", " << width << " m wide, drop " << c << ", step " << k;
        }
      }
}

}  // namespace unibody::small_worlds::invariants_test
