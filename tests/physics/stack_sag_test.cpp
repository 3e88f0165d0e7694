// Stacks of an unconverged solver: how far it lets them sink.
#include <gtest/gtest.h>

#include <algorithm>

#include "constraints/random_bench.hpp"
#include "small_worlds.hpp"
#include "solve/momentum.hpp"

namespace unibody::small_worlds::stack_sag_test {

namespace {

// The sum of all penetrations (mm) of ten discs that start at rest and touch, as a mean over frames 101 to 200. The settings are
// those of the independent code: a position stage, no bound of the speed of recovery, Nesterov's momentum.
double sag(const std::string& solver, int iterations, double warm_start, Stages stages = Stages::position,
           const Body& lowest = disc(1, 0.5, Vec3(0, 0, 0.5)), double scaling = 1,
           Acceleration acceleration = Acceleration::nesterov) {
  Scene scene = scene_with(0.5);
  scene.planar = true, scene.gravity = Vec3(0, 0, -9.8);
  scene.solver.name = solver, scene.solver.iterations = iterations, scene.solver.warm_start = warm_start;
  scene.solver.acceleration = acceleration, scene.solver.stages = stages, scene.solver.velocity_share = 0.5,
  scene.solver.leak = 0;
  scene.solver.order = Order::sequential, scene.solver.scaling = scaling;
  scene.solver.recovery_time = 0, scene.solver.recovery_speed = 0, scene.solver.tolerance = 0;
  for (Body body = lowest; body.state.position.z() < 10; body.state.position.z() += 1) add(scene, body);
  add(scene, ground());
  Experiment run(scene);
  double sum = 0;
  for (int frame = 1; frame <= 200; ++frame) {
    run.step();
    if (frame <= 100) continue;
    sum += std::max(0.0, 0.5 - run.position(0).z());
    for (Id k = 1; k < 10; ++k) sum += std::max(0.0, 1 - (run.position(k) - run.position(k - 1)).norm());
  }
  return 1000 * sum / 100;
}

// The same with a Gauss-Seidel that always sweeps upwards (the solver's own alternates), step by step from its parts.
double sag_sweeping_upwards(int iterations) {
  Bench bench;
  bench.planar = true, bench.gravity = Vec3(0, 0, -9.8);
  std::vector<Body> bodies;
  for (int k = 0; k < 10; ++k) bodies.push_back(disc(1, 0.5, Vec3(0, 0, 0.5 + k)));
  bodies.push_back(ground());
  bench.world.homes = 10;
  bench.world.resize(11);
  for (std::size_t k = 0; k < 11; ++k) bodies[k].id = static_cast<Id>(k), bench.world.set(k, bodies[k]);
  CollideSettings settings;
  settings.gravity = bench.gravity, settings.planar = true;
  double sum = 0;
  for (int frame = 1; frame <= 200; ++frame) {
    collide(bench.world, settings, bench.contacts);
    const auto n = static_cast<std::uint32_t>(bench.contacts.manifolds.size());
    std::vector<std::uint32_t> order(n);
    for (std::uint32_t m = 0; m < n; ++m) order[m] = m;
    const auto upper = [&](std::uint32_t m) { return bench.contacts.manifolds[m].id_b % 10; };  // the ground, 10, comes first
    std::sort(order.begin(), order.end(), [&](auto a, auto b) { return upper(a) < upper(b); });
    bench.build_sequential(order);
    bench.start({Stage::Kind::position, bench.step, 0, 0});
    for (int k = 0; k < iterations; ++k)
      for (std::size_t m = 0; m < n; ++m) bench.system.contacts().relax(m, false, bench.system.bodies);
    for (std::size_t i = 0; i < 10; ++i)
      bench.world.set_state(i, finish_motion(bench.world.properties[i], bench.world.state(i), bench.system.bodies[i],
                                             Vec3::Zero(), bench.step, true));
    if (frame <= 100) continue;
    sum += std::max(0.0, 0.5 - bench.world.position[0].z());
    for (std::size_t k = 1; k < 10; ++k) sum += std::max(0.0, 1 - (bench.world.position[k] - bench.world.position[k - 1]).norm());
  }
  return 1000 * sum / 100;
}

}  // namespace

// Cold: the sag of each mode is (1 - s) / s h^2 g, with s its convergence in one step; figures of an independent code, 5 %.
TEST(StackSag, SagOfAnUnconvergedJacobi) {
  EXPECT_NEAR(sag("jacobi", 10, 0), 48.5, 0.05 * 48.5);
  EXPECT_NEAR(sag("jacobi", 20, 0), 23.6, 0.05 * 23.6);
  EXPECT_NEAR(sag("jacobi", 50, 0), 8.70, 0.05 * 8.70);
  EXPECT_NEAR(sag("jacobi", 100, 0), 3.70, 0.05 * 3.70);
}
TEST(StackSag, SagOfAcceleratedJacobi) {
  EXPECT_NEAR(sag("accelerated_jacobi", 10, 0), 23.7, 0.05 * 23.7);
  EXPECT_NEAR(sag("accelerated_jacobi", 20, 0), 6.04, 0.05 * 6.04);
  EXPECT_LT(sag("accelerated_jacobi", 50, 0), 0.007);  // that code's figure; the 1 / K^2 that momentum guarantees would be 0.97
}
// How far a mode much softer than the stiffest gets in so many iterations, over that of one.
double way_of_a_soft_mode(Acceleration acceleration, int iterations) {
  Momentum momentum(acceleration);
  double way = 0, start = 0;
  for (int k = 0; k < iterations; ++k) {
    const Extrapolation beyond = momentum.next({}, false);
    const double next = start + 1;
    start = next + beyond.momentum * (next - way) + beyond.overshoot * (next - start), way = next;
  }
  return way;
}

// (1 - s) / s is less, for every mode, by the factor of the softest at least.
TEST(StackSag, OptimizedAccelerationSagsLess) {
  const Body lowest = disc(1, 0.5, Vec3(0, 0, 0.5));
  for (const int k : {10, 20}) {
    const double factor = way_of_a_soft_mode(Acceleration::nesterov, k) / way_of_a_soft_mode(Acceleration::optimized, k);
    EXPECT_LT(factor, 0.6);
    EXPECT_LT(sag("accelerated_jacobi", k, 0, Stages::position, lowest, 1, Acceleration::optimized),
              factor * sag("accelerated_jacobi", k, 0))
        << k;
  }
}
TEST(StackSag, SagOfGaussSeidelSweepingUpwards) {
  EXPECT_NEAR(sag_sweeping_upwards(10), 10.16, 0.05 * 10.16);
  EXPECT_NEAR(sag_sweeping_upwards(20), 4.47, 0.05 * 4.47);
  EXPECT_NEAR(sag_sweeping_upwards(50), 1.17, 0.05 * 1.17);
  EXPECT_NEAR(sag_sweeping_upwards(100), 0.263, 0.05 * 0.263);
}
// Alternating costs some of that, and stays well ahead of Jacobi. With momentum it has less than a tenth of either after 50
// iterations.
TEST(StackSag, SagOfAlternatingGaussSeidel) {
  const auto plain = [](int iterations) {
    return sag("gauss_seidel", iterations, 0, Stages::position, disc(1, 0.5, Vec3(0, 0, 0.5)), 1, Acceleration::none);
  };
  EXPECT_LT(plain(10), sag("jacobi", 20, 0));
  EXPECT_LT(plain(50), sag("jacobi", 100, 0));
  EXPECT_GT(plain(50), sag_sweeping_upwards(50));
  EXPECT_LT(sag("gauss_seidel", 50, 0), 0.1 * sag_sweeping_upwards(50));
}
// Half of the multipliers kept halves every sag: the factor 1 - alpha of the closed form.
TEST(StackSag, HalfAWarmStartHalvesTheSag) {
  for (const std::string solver : {"jacobi", "accelerated_jacobi", "gauss_seidel"}) {
    const double cold = sag(solver, 20, 0), warm = sag(solver, 20, 0.5);
    EXPECT_NEAR(warm, cold / 2, 0.01 * cold) << solver;
  }
}

// The velocity stage starts from all of its last multipliers, so that a stack which has settled does not sag. With few
// iterations, half of which are the velocity stage's, some sag is left: the figures are the independent code's.
TEST(StackSag, VelocityStageRemovesTheSag) {
  EXPECT_NEAR(sag("jacobi", 10, 0, Stages::two), 5.3, 0.05 * 5.3);
  EXPECT_NEAR(sag("jacobi", 20, 0, Stages::two), 0.32, 0.05 * 0.32);
  EXPECT_NEAR(sag("accelerated_jacobi", 10, 0, Stages::two), 1.9, 0.05 * 1.9);
  EXPECT_NEAR(sag("accelerated_jacobi", 20, 0, Stages::two), 0.003, 0.0005);
  EXPECT_LT(sag("gauss_seidel", 10, 0, Stages::two), 0.02);
  EXPECT_LT(sag("jacobi", 100, 0, Stages::two), 0.005);
  EXPECT_LT(sag("accelerated_jacobi", 20, 0, Stages::two), 0.01);
  EXPECT_LT(sag("accelerated_jacobi", 50, 0, Stages::two), 0.005);
  EXPECT_LT(sag("gauss_seidel", 20, 0, Stages::two), 0.005);
}

// Two boxes of the planar scene touch at two corners. The independent code splits a body's mass by its contact points and this
// program by its pairs, so that the independent code takes shorter steps: the sag that it has after 10, 20, 50 and 100 iterations
// is an upper bound of this program's.
TEST(StackSag, SagOfBoxes) {
  const Body box = block(1, Vec3(1, 1, 1), Vec3(0, 0, 0.5));
  const int iterations[] = {10, 20, 50, 100};
  const double jacobi[] = {198, 97.5, 38.7, 18.7}, accelerated[] = {98.3, 28.96, 3.915, 0.037},
               warm_accelerated[] = {50.2, 14.5, 1.96, 0.018}, two[] = {77, 5.5, 0.01, 0.01};
  for (int k = 0; k < 4; ++k) {
    const double cold = sag("jacobi", iterations[k], 0, Stages::position, box);
    EXPECT_LT(cold, jacobi[k]) << iterations[k];
    EXPECT_GT(cold, 0.3 * jacobi[k]) << iterations[k] << ": it sags";
    EXPECT_LT(sag("accelerated_jacobi", iterations[k], 0, Stages::position, box), accelerated[k]) << iterations[k];
    EXPECT_LT(sag("accelerated_jacobi", iterations[k], 0.5, Stages::position, box), warm_accelerated[k]) << iterations[k];
    EXPECT_LT(sag("accelerated_jacobi", iterations[k], 0, Stages::two, box), two[k]) << iterations[k];
  }
  // A scaling of 2 splits the masses by points here too, as each pair has two. The codes then differ in how they bound the row
  // sums of a pair alone: this program takes the pair as one block, and its steps are shorter.
  for (int k = 0; k < 2; ++k) {
    const double shared = sag("jacobi", iterations[k], 0, Stages::position, box, 2),
                 momentum = sag("accelerated_jacobi", iterations[k], 0, Stages::position, box, 2);
    EXPECT_GT(shared, 0.75 * jacobi[k]) << iterations[k];
    EXPECT_LT(shared, jacobi[k]) << iterations[k];
    EXPECT_GT(momentum, 0.75 * accelerated[k]) << iterations[k];
    EXPECT_LT(momentum, accelerated[k]) << iterations[k];
  }
  const double cold = sag("accelerated_jacobi", 20, 0, Stages::position, box);
  EXPECT_NEAR(sag("accelerated_jacobi", 20, 0.5, Stages::position, box), cold / 2, 0.01 * cold);
}

}  // namespace unibody::small_worlds::stack_sag_test
