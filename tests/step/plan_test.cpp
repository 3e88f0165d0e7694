// The plan of a step as a table: each setting that a scene may leave open, and each way in which it is decided.
#include "step/plan.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace unibody::plan_test {
namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();

SceneTraits grains() {
  SceneTraits traits;
  traits.frame = 0.02, traits.step = 0.005, traits.gravity = 10, traits.smallest_size = 0.06;
  return traits;
}
SceneTraits cloth() {
  SceneTraits traits = grains();
  traits.has_centre_constraints = traits.only_links = true;
  return traits;
}
SceneTraits machine() {
  SceneTraits traits = grains();
  traits.has_joints = true;
  return traits;
}
SolverSettings solver(const char* name, int iterations = 50) {
  SolverSettings settings;
  settings.name = name, settings.iterations = iterations;
  return settings;
}
SolverSettings at_velocity_level() {
  SolverSettings settings = solver("accelerated_jacobi");
  settings.level = Level::velocity;
  return settings;
}

}  // namespace

// Half a millisecond of counted work, in ns, holds so many iterations.
TEST(StepPlan, AnOpenCountOfIterationsGoesByWhatTheyCost) {
  StepFacts facts;
  const auto open = [&](std::int64_t work, SolverSettings settings = {}) {
    facts.work = work;
    return unibody::plan(settings, grains(), facts);
  };
  EXPECT_EQ(open(0).iterations, 50);  // it is not known
  EXPECT_EQ(open(100).iterations, 1000);
  EXPECT_EQ(open(2000).iterations, 250);
  EXPECT_EQ(open(10'001).iterations, 50);
  EXPECT_EQ(open(2000, solver("accelerated_jacobi", 60)).iterations, 60);
  SolverSettings settings;
  settings.tolerance = 0;  // no step would stop before
  EXPECT_EQ(open(2000, settings).iterations, 50);
  settings = {}, settings.accuracy = 0.01;
  EXPECT_EQ(open(10'001, settings).iterations, 1000);

  facts.any_contact = true;
  const StepPlan more = open(2000), usual = unibody::plan(solver("accelerated_jacobi"), grains(), facts);
  EXPECT_EQ(more.velocity_iterations, 200);
  EXPECT_EQ(more.least_velocity_iterations, 40);
  EXPECT_EQ(more.least_position_iterations, 10);
  EXPECT_EQ(more.aim, more.tolerance);
  EXPECT_EQ(more.uneven_share, usual.uneven_share);
  EXPECT_EQ(more.leak, usual.leak);
  EXPECT_EQ(usual.least_velocity_iterations, 0);
}

TEST(StepPlan, SizesGoByTheSmallestBody) {
  const StepPlan plan = unibody::plan({}, grains());
  EXPECT_DOUBLE_EQ(plan.tolerance, 2e-5 * 0.06 / 16);  // a quarter of a frame
  EXPECT_DOUBLE_EQ(plan.margin, 0.002);                // a fifth of the size is more
  EXPECT_DOUBLE_EQ(plan.recovery_speed, 0.25);
  EXPECT_DOUBLE_EQ(plan.recovery_time, 0.02);  // a frame, not a step
  EXPECT_EQ(plan.surface_recovery_time, 0);

  EXPECT_DOUBLE_EQ(least_creep(grains()), std::min(1.5 * plan.tolerance, 1e-3 * grains().gravity * 0.005 * 0.005));

  SceneTraits dust = grains();
  dust.smallest_size = 0.0006;
  const StepPlan small = unibody::plan({}, dust);
  EXPECT_DOUBLE_EQ(small.tolerance, 0.01 * plan.tolerance);
  EXPECT_DOUBLE_EQ(small.margin, 0.00012);
  SceneTraits jointed = grains();
  jointed.has_joints = true;
  EXPECT_DOUBLE_EQ(unibody::plan({}, jointed).tolerance, 5e-5 * 0.06 / 16);
  EXPECT_DOUBLE_EQ(small.recovery_speed, std::sqrt(2 * 10 * 0.0006 / 3));
  dust.gravity = 0;
  EXPECT_DOUBLE_EQ(unibody::plan({}, dust).recovery_speed, 0.25);

  SceneTraits nothing_moves = grains();
  nothing_moves.smallest_size = infinite;
  EXPECT_EQ(unibody::plan({}, nothing_moves).tolerance, 0);
  EXPECT_EQ(unibody::plan({}, nothing_moves).margin, 0.002);
}

// The automatic tolerance, per second, falls as the number of steps in a frame grows. It is no more than a share of what a body
// falls in the step.
TEST(StepPlan, TheToleranceFallsWithTheStep) {
  const auto tolerance = [](double frame, int parts) {
    SceneTraits traits = grains();
    traits.frame = frame, traits.step = frame / parts;
    return unibody::plan({}, traits).tolerance;
  };
  EXPECT_DOUBLE_EQ(tolerance(0.016, 1), 1.2e-6);
  for (const int parts : {4, 16}) EXPECT_DOUBLE_EQ(parts * tolerance(0.016, parts) / 0.016, 1.2e-6 / 0.016 / parts);
  EXPECT_DOUBLE_EQ(tolerance(0.001, 1), 0.04 * 10 * 1e-6);
  SceneTraits weightless = grains();
  weightless.frame = weightless.step = 0.001, weightless.gravity = 0;
  EXPECT_DOUBLE_EQ(unibody::plan({}, weightless).tolerance, 1.2e-6);
}

// With an accuracy a step stops at a residual: the part of the accuracy that falls to this step, divided by the ratio of error to
// residual. The first iterations of each stage go for the usual tolerance instead.
TEST(StepPlan, AnAccuracyIsAToleranceByTheRatioOfErrorToResidual) {
  SolverSettings settings = solver("accelerated_jacobi", 1000);
  settings.accuracy = 1e-2;
  const double part = 1e-2 * 0.06 / 4;  // of the frame's, a quarter of it
  const StepPlan unknown = unibody::plan(settings, grains());
  EXPECT_DOUBLE_EQ(unknown.tolerance, part / 3);
  EXPECT_DOUBLE_EQ(unknown.aim, 1e-4 * 0.06 / 16);
  StepFacts facts;
  facts.error_ratio = 12;
  EXPECT_DOUBLE_EQ(unibody::plan(settings, grains(), facts).tolerance, part / 12);
  facts.error_ratio = 0.1;
  EXPECT_DOUBLE_EQ(unibody::plan(settings, grains(), facts).tolerance, part / 3);
  settings.accuracy = 1e-5;  // below the usual tolerance
  const StepPlan fine = unibody::plan(settings, grains(), facts);
  EXPECT_DOUBLE_EQ(fine.tolerance, 1e-3 * part / 3);
  EXPECT_EQ(fine.aim, fine.tolerance);

  facts.any_contact = true;
  const StepPlan two = unibody::plan(settings, grains(), facts);
  EXPECT_EQ(two.least_of(Stage::Kind::velocity), 40);
  EXPECT_EQ(two.least_of(Stage::Kind::position), 10);
  EXPECT_EQ(unibody::plan(settings, cloth(), facts).least_of(Stage::Kind::position), 50);

  const StepPlan without = unibody::plan(solver("accelerated_jacobi"), grains(), facts);
  EXPECT_EQ(without.least_of(Stage::Kind::velocity) + without.least_of(Stage::Kind::position), 0);
  EXPECT_EQ(without.aim, without.tolerance);
}

// Up to 50 iterations a third of the old multipliers, then as much less as there are more iterations.
TEST(StepPlan, TheOldMultipliersCountLessOfMoreIterations) {
  const auto share = [](int iterations) { return unibody::plan(solver("accelerated_jacobi", iterations), cloth()).share; };
  EXPECT_EQ(share(10), 1.0 / 3);
  EXPECT_EQ(share(50), 1.0 / 3);
  EXPECT_DOUBLE_EQ(share(100), 1.0 / 6);
  EXPECT_DOUBLE_EQ(share(1000), 1.0 / 60);
  SolverSettings set = solver("accelerated_jacobi", 1000);
  set.warm_start = 0.3;
  EXPECT_EQ(unibody::plan(set, cloth()).share, 0.3);
}

TEST(StepPlan, WhatTheSceneSetsStands) {
  SolverSettings set;
  set.tolerance = 1e-3, set.margin = 0.5, set.recovery_speed = 0, set.recovery_time = 0.7, set.velocity_share = 0.25,
  set.leak = 0.9;
  set.warm_start = 0.1;
  const StepPlan plan = unibody::plan(set, grains(), {.any_contact = true});
  EXPECT_EQ(plan.tolerance, 1e-3);
  EXPECT_EQ(plan.margin, 0.5);
  EXPECT_EQ(plan.recovery_speed, 0);
  EXPECT_EQ(plan.recovery_time, 0.7);
  EXPECT_EQ(plan.surface_recovery_time, 0.7);
  EXPECT_EQ(plan.velocity_share, 0.25);
  EXPECT_EQ(plan.velocity_iterations, 12);
  EXPECT_EQ(plan.leak, 0.9);
  EXPECT_EQ(plan.contacts_share, 1);  // of two stages the first starts from all
  set.stages = Stages::position;
  EXPECT_EQ(unibody::plan(set, grains()).contacts_share, 0.1);
}

TEST(StepPlan, StagesAndTheirShares) {
  struct Row {
    const char* what;
    SolverSettings settings;
    SceneTraits traits;
    bool any_contact;
    Stages stages;
    bool two_stages;
    int velocity_iterations;
    double contacts_share, share;
    bool solids_start_cold;
  };
  const double third = 1.0 / 3;
  const Row rows[] = {
      {"grains, accelerated", solver("accelerated_jacobi"), grains(), false, Stages::two, true, 40, 1, 0, false},
      {"grains, plain Jacobi", solver("jacobi"), grains(), false, Stages::two, true, 25, 1, 0, false},
      {"grains, Gauss-Seidel", solver("gauss_seidel", 10), grains(), false, Stages::two, true, 5, 1, 0, false},
      {"two iterations", solver("accelerated_jacobi", 2), grains(), false, Stages::two, true, 1, 1, 0, false},
      {"cloth, Jacobi", solver("accelerated_jacobi"), cloth(), true, Stages::position, false, 0, third, third, true},
      {"cloth, Gauss-Seidel, touched", solver("gauss_seidel"), cloth(), true, Stages::two, true, 25, 1, third, false},
      {"cloth, Gauss-Seidel, alone", solver("gauss_seidel"), cloth(), false, Stages::two, false, 0, 1, third, false},
      {"machine, Jacobi", solver("accelerated_jacobi"), machine(), true, Stages::position, false, 0, third, third, true},
      {"machine, Gauss-Seidel", solver("gauss_seidel"), machine(), true, Stages::two, true, 25, 1, third, false},
      {"velocity level", at_velocity_level(), grains(), true, Stages::position, false, 0, 0.5, 0, false},
  };
  for (const Row& row : rows) {
    const StepPlan plan = unibody::plan(row.settings, row.traits, {.any_contact = row.any_contact});
    EXPECT_EQ(plan.stages, row.stages) << row.what;
    EXPECT_EQ(plan.two_stages, row.two_stages) << row.what;
    EXPECT_EQ(plan.velocity_iterations, row.velocity_iterations) << row.what;
    EXPECT_EQ(plan.contacts_share, row.contacts_share) << row.what;
    EXPECT_EQ(plan.share, row.share) << row.what;
    EXPECT_EQ(plan.solids_start_cold, row.solids_start_cold) << row.what;
  }
}

// Where a step finds contacts of both kinds of islands, each kind has the plan of a scene of its own.
TEST(StepPlan, IslandsHaveTheirOwn) {
  for (const char* name : {"accelerated_jacobi", "jacobi", "gauss_seidel"}) {
    EXPECT_TRUE(asks_for_islands(solver(name), cloth())) << name;
    EXPECT_FALSE(asks_for_islands(solver(name), grains())) << name;
    const StepFacts facts{.any_contact = true, .free_contacts = true, .constrained_contacts = true};
    const StepPlan constrained = unibody::plan(solver(name), cloth(), facts);
    const StepPlan free = plan_of_free_islands(solver(name), cloth(), facts);
    const StepPlan of_cloth = unibody::plan(solver(name), cloth(), {.any_contact = true});
    const StepPlan of_grains = unibody::plan(solver(name), grains(), {.any_contact = true});
    EXPECT_EQ(constrained.islands, Islands::constrained);
    EXPECT_EQ(free.islands, Islands::free);
    EXPECT_EQ(of_cloth.islands, Islands::all);
    for (const auto& [apart, own] : {std::pair(constrained, of_cloth), std::pair(free, of_grains)}) {
      EXPECT_EQ(apart.stages, own.stages) << name;
      EXPECT_EQ(apart.velocity_iterations, own.velocity_iterations) << name;
      EXPECT_EQ(apart.contacts_share, own.contacts_share) << name;
      EXPECT_EQ(apart.leak, own.leak) << name;
      EXPECT_EQ(apart.most_weights, own.most_weights) << name;
      EXPECT_EQ(apart.velocity_acceleration, own.velocity_acceleration) << name;
      EXPECT_EQ(apart.position_acceleration, own.position_acceleration) << name;
    }
  }
  const StepFacts free_only{.any_contact = true, .free_contacts = true};
  EXPECT_FALSE(unibody::plan(solver("gauss_seidel"), cloth(), free_only).two_stages) << "its islands touch nothing";
  SolverSettings set;
  set.stages = Stages::two;
  EXPECT_FALSE(asks_for_islands(set, cloth())) << "the scene has decided";
}

TEST(StepPlan, OldDifferencesAreForgottenFasterWithMoreIterations) {
  const auto share = [](const char* name, int iterations) {
    return unibody::plan(solver(name, iterations), grains()).uneven_share;
  };
  for (const char* name : {"accelerated_jacobi", "gauss_seidel"}) {
    EXPECT_EQ(share(name, 20), 1) << name;
    EXPECT_EQ(share(name, 30), 1) << name;
    EXPECT_LT(share(name, 100), share(name, 50)) << name;
  }
  EXPECT_EQ(share("jacobi", 100), 1);
  SceneTraits whole = grains(), finer = grains();
  whole.step = whole.frame, finer.step = finer.frame / 4;
  const auto of = [](const SceneTraits& traits) { return unibody::plan(solver("gauss_seidel", 100), traits).uneven_share; };
  EXPECT_LT(of(whole), 1);
  EXPECT_NEAR(std::pow(of(finer), 4), of(whole), 1e-12) << "of a frame, whatever its steps";
}

TEST(StepPlan, TheLeakGoesBySolverAndIterations) {
  const auto leak = [](const char* name, int iterations) { return unibody::plan(solver(name, iterations), grains()).leak; };
  EXPECT_EQ(leak("accelerated_jacobi", 50), 0.6);
  EXPECT_EQ(leak("accelerated_jacobi", 20), 0.15);
  EXPECT_EQ(leak("accelerated_jacobi", 10), 0);
  EXPECT_EQ(leak("jacobi", 50), 0);
  EXPECT_EQ(leak("gauss_seidel", 10), 0.3);
  EXPECT_EQ(leak("gauss_seidel", 5), 0.15);
  EXPECT_EQ(unibody::plan(solver("gauss_seidel", 20), grains()).swelling, 0.002);
  EXPECT_EQ(unibody::plan(solver("gauss_seidel", 20), grains()).most_weights, 0);
  EXPECT_EQ(unibody::plan(solver("gauss_seidel", 50), grains()).swelling, 0);
  EXPECT_EQ(unibody::plan(solver("gauss_seidel", 50), cloth(), {.any_contact = true}).swelling, 0);
  EXPECT_DOUBLE_EQ(unibody::plan(solver("gauss_seidel", 50), cloth(), {.any_contact = true}).most_weights, 12.5);
  EXPECT_DOUBLE_EQ(unibody::plan(solver("gauss_seidel", 50), grains()).most_weights, 16);
  EXPECT_DOUBLE_EQ(unibody::plan(solver("accelerated_jacobi"), grains()).most_weights, 10);
}

// The plan has the total form where the tetrahedra of solids are all soft enough. It never has it for the solver newton, at
// velocity level, or beside a coarse level.
TEST(StepPlan, TheFormGoesByTheStiffestTetrahedron) {
  SceneTraits solid = cloth();
  solid.only_links = false, solid.has_solids = true;
  EXPECT_EQ(unibody::plan({}, solid).form, Form::incremental) << "it is not known how stiff they are";
  solid.stiffness = 30.1;
  EXPECT_EQ(unibody::plan({}, solid).form, Form::incremental);
  solid.stiffness = 29.9;
  for (const char* name : {"accelerated_jacobi", "jacobi", "gauss_seidel"})
    EXPECT_EQ(unibody::plan(solver(name), solid).form, Form::total);
  EXPECT_EQ(unibody::plan(solver("newton"), solid).form, Form::incremental);
  EXPECT_EQ(unibody::plan(at_velocity_level(), solid).form, Form::incremental);
  SolverSettings settings;
  settings.coarse = true;
  EXPECT_EQ(unibody::plan(settings, solid).form, Form::incremental);
  settings.coarse = false, settings.form = Form::incremental;
  EXPECT_EQ(unibody::plan(settings, solid).form, Form::incremental);
  settings.form = Form::total, solid.stiffness = infinite;
  EXPECT_EQ(unibody::plan(settings, solid).form, Form::total) << "as the scene says";
  SceneTraits links = cloth();
  links.stiffness = 1;
  EXPECT_EQ(unibody::plan({}, links).form, Form::incremental);
}

TEST(StepPlan, GaussSeidelHasMomentumButForElements) {
  SceneTraits links = grains(), solids = grains();
  links.has_centre_constraints = links.only_links = solids.has_centre_constraints = true, solids.only_links = false;
  EXPECT_EQ(unibody::plan(solver("gauss_seidel"), links).position_acceleration, Acceleration::nesterov);
  EXPECT_EQ(unibody::plan(solver("gauss_seidel"), solids).position_acceleration, Acceleration::none);
  EXPECT_EQ(unibody::plan(solver("gauss_seidel"), solids).velocity_acceleration, Acceleration::nesterov);
  SolverSettings plain = solver("gauss_seidel");
  plain.acceleration = Acceleration::none;
  EXPECT_EQ(unibody::plan(plain, links).position_acceleration, Acceleration::none);
  EXPECT_EQ(unibody::plan(plain, grains()).velocity_share, 0.5) << "as with few iterations";
}

TEST(StepPlan, AccelerationOfTheTwoStages) {
  constexpr Acceleration optimized = Acceleration::optimized, nesterov = Acceleration::nesterov;
  struct Row {
    const char* what;
    SceneTraits traits;
    StepFacts facts;
    Acceleration velocity, position;
  };
  SceneTraits membrane = cloth(), tied = cloth();
  membrane.only_links = false, tied.has_attachments = true;
  const Row rows[] = {
      {"grains", grains(), {}, optimized, optimized},    {"grains that bounce", grains(), {.bounces = true}, nesterov, nesterov},
      {"links", cloth(), {}, optimized, optimized},      {"tight links", cloth(), {.links_are_tight = true}, optimized, nesterov},
      {"a membrane", membrane, {}, optimized, nesterov}, {"links tied to a body", tied, {}, optimized, nesterov},
      {"joints", machine(), {}, optimized, nesterov},
  };
  for (const Row& row : rows) {
    const StepPlan plan = unibody::plan({}, row.traits, row.facts);
    EXPECT_EQ(plan.velocity_acceleration, row.velocity) << row.what;
    EXPECT_EQ(plan.position_acceleration, row.position) << row.what;
    EXPECT_EQ(plan.most_stiffness, row.position == optimized ? most_geometric_stiffness : infinite) << row.what;
  }
  SolverSettings set;
  set.gap = Gap::reevaluated;
  EXPECT_EQ(unibody::plan(set, grains()).position_acceleration, nesterov);
  set = {}, set.scaling = 0.5;
  EXPECT_EQ(unibody::plan(set, grains()).velocity_acceleration, nesterov);
  set.acceleration = optimized;
  EXPECT_EQ(unibody::plan(set, machine()).position_acceleration, optimized);
  EXPECT_EQ(unibody::plan(solver("jacobi"), cloth()).most_stiffness, infinite) << "it has no momentum to bound for";
}

TEST(StepPlan, TightLinksAreLookedForWhereTheyMatter) {
  EXPECT_TRUE(asks_for_tight_links({}, cloth()));
  EXPECT_FALSE(asks_for_tight_links({}, grains()));
  EXPECT_FALSE(asks_for_tight_links(solver("gauss_seidel"), cloth()));
  SolverSettings set;
  set.acceleration = Acceleration::nesterov;
  EXPECT_FALSE(asks_for_tight_links(set, cloth()));
  EXPECT_FALSE(links_are_tight(3 * tight_links));  // of which a third is a step's start
  EXPECT_TRUE(links_are_tight(3.01 * tight_links));
  EXPECT_TRUE(links_are_tight(NAN));
}

TEST(StepPlan, Stages) {
  SolverSettings set;
  set.gap = Gap::reevaluated;
  const StepPlan plan = unibody::plan(set, grains());
  const Stage velocity = plan.stage(Stage::Kind::velocity, set, 0.005), position = plan.stage(Stage::Kind::position, set, 0.005);
  EXPECT_FALSE(velocity.reevaluates);
  EXPECT_TRUE(position.reevaluates);
  EXPECT_EQ(velocity.bias(-0.01), 0);
  EXPECT_DOUBLE_EQ(position.bias(-0.001), -0.001 / 0.025);
  EXPECT_DOUBLE_EQ(position.bias(-1), -0.25);
  const SolverSettings linear = at_velocity_level();  // takes out the share gamma of an error
  EXPECT_DOUBLE_EQ(unibody::plan(linear, grains()).stage(Stage::Kind::position, linear, 0.005).bias(-1), -0.4 / 0.005);
}

}  // namespace unibody::plan_test
