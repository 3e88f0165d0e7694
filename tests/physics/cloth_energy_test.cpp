// What unconverged and damped cloths do to energy and stretch: closed forms, and the figures of an independent prototype.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "report/stretch.hpp"
#include "small_worlds.hpp"

namespace unibody::small_worlds::cloth_energy_test {

namespace {

// A square cloth of stiff links that falls from the horizontal and hangs from two corners; masses in kg.
Scene hanging(double size, int nodes, double damping = 0, const std::string& diagonals = "both", double mass = 10) {
  const std::string n = std::to_string(nodes), last = std::to_string(nodes - 1), side = std::to_string(size);
  Scene scene =
      scene_from_text("gravity: [0, 0, -9.8]\ncloths:\n  - grid: {size: [" + side + ", " + side + "], nodes: [" + n + ", " + n +
                      "]}\n    mass: " + std::to_string(mass) + "\n    thickness: 0.02\n    links: {diagonals: " + diagonals +
                      ", damping: " + std::to_string(damping) + "}\n    pins: [{node: [0, 0]}, {node: [" + last + ", 0]}]\n");
  scene.solver.tolerance = 0;
  return scene;
}

Stretch stretch_of(const Experiment& run) {
  return measure_stretch(MPI_COMM_SELF, run.simulation->world, run.simulation->ties.constraints, 1).at(0);
}

double median_of(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + values.size() / 2, values.end());
  return values[values.size() / 2];
}

}  // namespace

// The paper's smallest cloth, 10 m and 50 nodes wide, after 300 frames: stretch as of another code for the same method. To a
// tenth, though it agrees to 0.3 % where this was written: the fall is chaotic, and round-off grows.
TEST(ClothEnergy, UnconvergedStretchIsThatOfThePrototype) {
  struct Case {
    double warm;
    int iterations;
    double rms, max;
  };
  for (const Case& c : {Case{0, 10, .1003, 1.174},
                        {0, 20, .0582, .684},
                        {0, 50, .0245, .332},
                        {.5, 10, .0939, 1.097},
                        {.5, 20, .0599, .645},
                        {.5, 50, .0047, .057}}) {
    Scene scene = hanging(10, 50);
    scene.solver.warm_start = c.warm, scene.solver.iterations = c.iterations;
    scene.solver.acceleration = Acceleration::nesterov, scene.solver.mass_sharing = MassSharing::count;
    Experiment run(std::move(scene));
    run.steps(300);
    const Stretch stretch = stretch_of(run);
    EXPECT_NEAR(stretch.rms, c.rms, 0.1 * c.rms) << c.warm << ' ' << c.iterations;
    EXPECT_NEAR(stretch.max, c.max, 0.1 * c.max) << c.warm << ' ' << c.iterations;
  }
}

// Where the links of a node pull each way, dividing by three quarters of their number makes steps 4/3 as long: accelerated by
// momentum, what is left of a soft mode goes by 1 over the length of a step.
TEST(ClothEnergy, SharingByDirectionsLeavesLessStretch) {
  const auto rms = [](MassSharing sharing, int iterations) {
    Scene scene = hanging(10, 50);
    scene.solver.mass_sharing = sharing, scene.solver.iterations = iterations;
    Experiment run(std::move(scene));
    run.steps(200);
    std::vector<double> found;
    for (int frame = 0; frame < 100; ++frame) run.step(), found.push_back(stretch_of(run).rms);
    return median_of(found);
  };
  for (const int iterations : {20, 50})
    EXPECT_LT(rms(MassSharing::directions, iterations), 0.85 * rms(MassSharing::count, iterations)) << iterations;
}

// Gauss-Seidel on the cloth of which the PositionBasedDynamics library's Gauss-Seidel is known (one diagonal a cell, unit masses,
// cold): medians of the frames 201 to 300, to a tenth without momentum; with it a fifth less at least, and two thirds less with
// 50 iterations.
TEST(ClothEnergy, GaussSeidelLeavesTheStretchOfTheLibrarys) {
  struct Case {
    int iterations;
    double rms, max;
  };
  const auto medians = [](int iterations, Acceleration acceleration) {
    Scene scene = hanging(10, 50, 0, "alternating", 2500);
    scene.solver.name = "gauss_seidel", scene.solver.warm_start = 0, scene.solver.iterations = iterations;
    scene.solver.acceleration = acceleration;
    Experiment run(std::move(scene));
    run.steps(200);
    std::vector<double> rms, max;
    for (int frame = 0; frame < 100; ++frame) {
      run.step();
      const Stretch stretch = stretch_of(run);
      rms.push_back(stretch.rms), max.push_back(stretch.max);
    }
    return std::pair(median_of(rms), median_of(max));
  };
  for (const Case& c : {Case{10, .050, 1.00}, {20, .024, .52}, {50, .0117, .26}}) {
    const auto [rms, max] = medians(c.iterations, Acceleration::none);
    EXPECT_NEAR(rms, c.rms, 0.1 * c.rms) << c.iterations;
    EXPECT_NEAR(max, c.max, 0.1 * c.max) << c.iterations;
    const auto [less_rms, less_max] = medians(c.iterations, Acceleration::automatic);
    const double share = c.iterations < 50 ? 0.8 : 1.0 / 3;
    EXPECT_LT(less_rms, share * c.rms) << c.iterations;
    EXPECT_LT(less_max, share * c.max) << c.iterations;
  }
}

// Links bear the optimized acceleration as well as contacts do: after as many iterations a cloth of the default solver is
// stretched by less than three quarters of what Nesterov's leaves (.57 and .61 of it when this was written).
TEST(ClothEnergy, OptimizedAccelerationLeavesLessStretch) {
  const auto rms = [](Acceleration acceleration, int iterations) {
    Scene scene = hanging(10, 50, 0, "alternating");
    scene.solver.acceleration = acceleration, scene.solver.iterations = iterations;
    Experiment run(std::move(scene));
    run.steps(200);
    std::vector<double> found;
    for (int frame = 0; frame < 100; ++frame) run.step(), found.push_back(stretch_of(run).rms);
    return median_of(found);
  };
  for (const int iterations : {20, 50})
    EXPECT_LT(rms(Acceleration::automatic, iterations), 0.75 * rms(Acceleration::nesterov, iterations)) << iterations;
}

// A cloth far from converged hangs by links whose geometric stiffness is more than steps bear. Where they start from a third of
// the old multipliers all the same it swings up from step to step, with 10 iterations to 1e10 times its size in 300 frames.
TEST(ClothEnergy, TightLinksDoNotSwingUp) {
  for (const auto acceleration : {Acceleration::automatic, Acceleration::optimized})
    for (const int iterations : {10, 50}) {
      Scene scene = hanging(10, 100, 0, "alternating");
      scene.solver.acceleration = acceleration, scene.solver.iterations = iterations;
      Experiment run(std::move(scene));
      run.steps(300);
      EXPECT_LT(stretch_of(run).rms, iterations == 10 ? 1 : 0.1) << iterations;
    }
}

// A start that stretches stiff links by 2 %: without damping the first step takes all of it, with damping rho each step takes
// h / (h + rho), so that the energy falls by the square of rho / (h + rho): to 1e-16 of itself in 200 frames.
TEST(ClothEnergy, StretchDiesAtTheRateOfTheDamping) {
  const double h = 0.016;
  for (const double damping : {0.0, 10 * h}) {
    Scene scene = hanging(1, 8, damping);
    scene.gravity = Vec3::Zero(), scene.pins.clear(), scene.solver.iterations = 400;
    Experiment run(std::move(scene));
    const auto rest = run.world().position;
    for (Vec3& x : run.world().position) x *= 1.02;
    const double start = run.energy(), rate = damping / (h + damping);
    EXPECT_EQ(start, 0);
    double stretch = 0.02, first = 0;
    for (int k = 0; k < 200; ++k) {
      run.step(), stretch *= rate;
      if (k == 0) first = run.kinetic_energy();
      for (std::size_t i = 0; i < rest.size(); ++i)
        ASSERT_LT((run.world().position[i] - (1 + stretch) * rest[i]).norm(), 1e-8) << damping << ' ' << k;
    }
    EXPECT_LT(run.kinetic_energy(), 1e-15 * first) << damping;
  }
}

// A swinging cloth of 30 x 30 nodes at 50 iterations. The mean kinetic energy from frame 400 to 800 is the prototype's, 14.3 J,
// from a cold start (to 15 %: the fall is chaotic). Damping of ten steps takes stretch out more slowly, by h / (h + rho): what is
// not converged sags up to 11 times as far, and lets the cloth down by that; this cloth is rubber, and its energy no longer that
// of the undamped one.
TEST(ClothEnergy, DampingOfAnUnconvergedClothIsPaidInStretch) {
  std::vector<Stretch> stretches;
  for (const double damping : {0.0, 0.16}) {
    Scene scene = hanging(2.9, 30, damping);
    scene.solver.warm_start = 0;
    Experiment run(std::move(scene));
    double mean = 0, before = run.energy();
    for (int k = 1; k <= 800; ++k) {
      run.step();
      if (k > 400) mean += run.kinetic_energy() / 400;
      if (k % 100 > 0) continue;
      EXPECT_LT(run.energy(), before) << damping << ' ' << k;
      before = run.energy();
    }
    if (damping == 0) {
      EXPECT_NEAR(mean, 14.3, 0.15 * 14.3);
    }
    EXPECT_GT(mean, 1) << damping;
    stretches.push_back(stretch_of(run));
  }
  EXPECT_GT(stretches[1].rms, 4 * stretches[0].rms);
  EXPECT_LT(stretches[1].rms, 11 * stretches[0].rms);
}

// Converged, the swinging cloth keeps stretches of a thousandth, and damping does not brake what stretches nothing: of the mean
// kinetic energy from frame 200 to 400 no more than a quarter goes, as in the prototype.
TEST(ClothEnergy, DampingLeavesSwingingAlone) {
  std::vector<double> means;
  for (const double damping : {0.0, 0.16}) {
    Scene scene = hanging(2.9, 30, damping);
    scene.solver.warm_start = 0, scene.solver.iterations = 400;
    Experiment run(std::move(scene));
    double& mean = means.emplace_back(0);
    for (int k = 1; k <= 400; ++k) {
      run.step();
      if (k > 200) mean += run.kinetic_energy() / 200;
    }
    EXPECT_LT(stretch_of(run).rms, 0.005) << damping;
  }
  EXPECT_GT(means[1], 0.75 * means[0]);
  EXPECT_LT(means[1], means[0]);
}

}  // namespace unibody::small_worlds::cloth_energy_test
