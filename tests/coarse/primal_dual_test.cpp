// Newton's method on two levels against the reference solver, which factorises, and what it leaves of cloths of many sizes.
#include "coarse/primal_dual.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "solve/reference_bench.hpp"

namespace unibody::small_worlds::primal_dual_test {

namespace {

constexpr double h = 0.004;

// One step of a scene's only cloth or solid, in as many iterations as it takes.
struct OneStep {
  std::vector<Vec3> velocity;
  ConstraintMultipliers multipliers;
  PrimalDualReport report;

  OneStep(const Scene& scene, const World& world, const ConstraintSet& constraints, double step,
          const PrimalDualSettings& settings, double start = 0) {
    Aggregates aggregates;
    std::vector<Vec3> points;
    for (Id k = 0; k < scene.body_count(); ++k) points.push_back(scene.body(k).state.position);
    aggregates.add(0, points);
    PrimalDual solver(world, constraints, aggregates, MPI_COMM_SELF);
    for_each_type(constraints, [&]<class C>(auto, const ConstraintList<C>&) {
      for (auto& one : solver.multipliers<C>())
        for (double& lambda : one) lambda = start;
    });
    const std::vector<SolverBody> predicted = predict_bodies(world, scene.gravity, step);
    const std::vector<std::int32_t> all(world.size(), 0);
    report = solver.solve({predicted, all, 1, step, [](std::span<Vec3>) {}}, settings);
    velocity = solver.velocities();
    for_each_type(constraints, [&]<class C>(auto type, const ConstraintList<C>&) {
      std::get<type.value>(multipliers) = solver.multipliers<C>();
    });
  }
};

PrimalDualSettings to_the_end() {
  PrimalDualSettings settings;
  settings.newton_iterations = 300, settings.linear_iterations = 500, settings.linear_share = 1e-10, settings.tolerance = 1e-13;
  return settings;
}

Scene solid() {
  Scene scene = scene_from_text(
      "solids:\n  - block: {size: [0.6, 0.2, 0.2], cells: [6, 2, 2]}\n    density: 1000\n    thickness: 0.01\n"
      "    youngs_modulus: 1.0e5\n    poissons_ratio: 0.3\n    damping: 0.01\n");
  scene.solver.tolerance = 0, scene.time.frame = h;
  return scene;
}

}  // namespace

// Springs, membranes with angles of bending, tetrahedra, all damped, and stiff links: velocities and impulses of the step.
TEST(PrimalDual, StepIsThatOfTheReference) {
  for (const ClothCase& of : {springs, membrane, stiff_links, ClothCase{"solid", ""}}) {
    const bool is_solid = of.model[0] == 0;
    Scene scene = is_solid ? solid() : cloth(of, 9, h);
    Experiment run(is_solid ? solid() : cloth(of, 9, h));
    run.simulation->detect();
    shake(run.world(), 0.3, 1e-4, 7);
    const ConstraintSet& constraints = run.simulation->ties.constraints;
    const ReferenceStep expected = reference_step(run.world(), constraints, scene.gravity, h);
    ASSERT_TRUE(expected.converged) << of.name << ' ' << expected.reason;
    const OneStep found(scene, run.world(), constraints, h, to_the_end());
    EXPECT_LT(largest_difference(found.velocity, expected.velocity), 1e-7 * largest(expected.velocity)) << of.name;
    for_each_type(constraints, [&]<class C>(auto type, const ConstraintList<C>& list) {
      const auto &a = std::get<type.value>(found.multipliers), &b = std::get<type.value>(expected.multipliers);
      double largest_impulse = 0, difference = 0;
      for (std::size_t i = 0; i < list.size(); ++i)
        for (std::size_t k = 0; k < C::rows; ++k) {
          largest_impulse = std::max(largest_impulse, std::abs(b[i][k]));
          difference = std::max(difference, std::abs(a[i][k] - b[i][k]));
        }
      EXPECT_LE(difference, 1e-5 * largest_impulse) << of.name << ' ' << C::name;
    });
    EXPECT_LT(std::max(found.report.residual, found.report.momentum()), 1e-10) << of.name;
  }
}

// Where the multipliers start changes how the solution is found, not which.
TEST(PrimalDual, SolutionIsThatOfAnyStart) {
  Scene scene = cloth(springs, 9, h);
  Experiment run(cloth(springs, 9, h));
  run.simulation->detect();
  shake(run.world(), 0.3, 1e-4, 7);
  const ConstraintSet& constraints = run.simulation->ties.constraints;
  const OneStep one(scene, run.world(), constraints, h, to_the_end()),
      other(scene, run.world(), constraints, h, to_the_end(), 1e-3);
  EXPECT_LT(largest_difference(one.velocity, other.velocity), 1e-8 * largest(one.velocity));
}

// What takes no part keeps its prediction, and its multipliers; what does is as if the rest were held.
TEST(PrimalDual, BodiesThatTakeNoPartKeepTheirPrediction) {
  Scene scene = cloth(springs, 9, h);
  Experiment run(cloth(springs, 9, h));
  run.simulation->detect();
  shake(run.world(), 0.3, 1e-4, 7);
  Aggregates aggregates;
  const std::vector<Vec3> points(81, Vec3::Zero());
  aggregates.add(0, points);
  PrimalDual solver(run.world(), run.simulation->ties.constraints, aggregates, MPI_COMM_SELF);
  auto& links = solver.multipliers<Distance>();
  for (auto& one : links) one[0] = 0.25;
  const std::vector<SolverBody> predicted = predict_bodies(run.world(), scene.gravity, h);
  std::vector<std::int32_t> some(run.world().size(), 0);
  for (std::size_t i = 0; i < 40; ++i) some[i] = -1;
  solver.solve({predicted, some, 1, h, [](std::span<Vec3>) {}}, to_the_end());
  int kept = 0, changed = 0;
  for (std::size_t i = 0; i < 81; ++i) {
    const bool same = solver.velocities()[i] == Vec3(predicted[i].v);
    EXPECT_EQ(same, some[i] < 0 || predicted[i].inverse_mass == 0) << i;
  }
  for (const auto& one : links) ++(one[0] == 0.25 ? kept : changed);
  EXPECT_GT(kept, 50);
  EXPECT_GT(changed, 50);
}

}  // namespace unibody::small_worlds::primal_dual_test
