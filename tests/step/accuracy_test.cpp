// An accuracy that is asked for: whether the steps are as good as they say, and what picks their iterations and their lengths.
#include "step/accuracy.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "core/errors.hpp"
#include "report/state_hash.hpp"
#include "small_worlds.hpp"
#include "step/division.hpp"

namespace unibody::small_worlds::accuracy_test {

namespace {

Scene governed(Scene scene, double accuracy) {
  scene.solver.accuracy = accuracy;
  return scene;
}

Scene pile() {
  return scene_from_text(R"(
bodies:
  - {shape: {plane: {normal: [0, 0, 1]}}}
  - pile:
      count: 60
      columns: [3, 2]
      seed: 5
      mix: [{shape: {box: {size: [0.2, 0.16, 0.12]}}}, {shape: {sphere: {radius: 0.08}}}]
    density: 1000
    velocity: [0, 0, -2]
)");
}

Scene tower() {
  Scene scene = scene_with(0.4);
  add(scene, ground());
  for (int i = 0; i < 15; ++i) add(scene, block(1 + i % 3, {0.2, 0.2, 0.1}, {0, 0, 0.05 + 0.1 * i}));
  return scene;
}

Scene rope() {
  return scene_from_text(R"(
bodies:
  - {shape: {sphere: {radius: 0.3}}, motion: fixed, position: [0.5, 0, -0.35]}
threads:
  - {name: rope, points: [[0, 0, 0], [1, 0, 0]], segments: 16, mass: 0.3, radius: 0.01, pins: [{node: 0}]}
)");
}

Scene arm() {
  return scene_from_text(R"(
bodies:
  - shape: {box: {size: [0.09, 0.03, 0.03]}}
    mass: 0.1
    position: [0, 0, 4]
    chain: {count: 8, from: [0, 0, 0], to: [0.8, 0, 0], held: start, joint: {type: ball}}
)");
}

struct Named {
  const char* name;
  Scene (*make)();
};

struct Told {
  int held = 0, wrong = 0;  // steps that say that they hold the accuracy, of those whose error was looked at; that do not
  double worst = 0;         // of their true errors over what is allowed
};

// The error of every fifth step, by the step solved until it converges, beside what the accuracy allows it.
Told truth_of(Scene scene, double accuracy, int steps) {
  Experiment e(governed(std::move(scene), accuracy));
  Told told;
  for (int k = 1; k <= steps; ++k) {
    StepRequest request;
    request.error = k % 5 == 0;
    const StepReport report = e.simulation->step(request);
    EXPECT_LE(report.residual, report.estimated_error);
    if (!report.error) continue;
    const double allowed = accuracy * e.simulation->traits.smallest_size, off = report.error->distance / allowed;
    if (!report.converged || report.estimated_error > allowed) continue;
    ++told.held, told.wrong += off > 1, told.worst = std::max(told.worst, off);
  }
  return told;
}

}  // namespace

// The judge is the step as it would be, had it been solved to the end. Of twenty steps most hold the accuracy, and say so; of
// these at most one may be off by more than was asked for, and none by more than three times of it.
TEST(Accuracy, IsHeldAsTheConvergedStepTells) {
  for (const auto& [name, scene] : {Named{"pile", pile}, {"tower", tower}, {"rope", rope}, {"arm", arm}})
    for (const double accuracy : {1e-2, 1e-3}) {
      SCOPED_TRACE(std::string(name) + ", " + std::to_string(accuracy));
      const Told told = truth_of(scene(), accuracy, 100);
      EXPECT_GE(told.held, 15);
      EXPECT_LE(told.wrong, 1);
      EXPECT_LT(told.worst, 3);
    }
}

// The usual iterations alone would not do.
TEST(Accuracy, AsksForMoreThanTheUsualIterations) {
  Scene scene = pile();
  scene.solver.iterations = default_iterations;
  Experiment e(scene);
  int wrong = 0;
  for (int k = 1; k <= 100; ++k) {
    StepRequest request;
    request.error = k % 5 == 0;
    const StepReport report = e.simulation->step(request);
    wrong += report.error && report.error->distance > 1e-3 * e.simulation->traits.smallest_size;
  }
  EXPECT_GT(wrong, 5);
}

// A short solve tells of the error what a long one tells, to a factor of 2, where there is some error to tell of. Of a step that
// is divided the long one tells of the last part, the short ones of all.
TEST(Accuracy, ASampleTellsTheError) {
  for (const auto& [name, scene] : {Named{"tower", tower}, {"rope", rope}}) {
    SCOPED_TRACE(name);
    Experiment e(governed(scene(), 1e-3));
    int samples = 0;
    for (int k = 0; k < 150; ++k) {
      const std::int64_t before = e.simulation->history.error_ratio.next;
      StepRequest request;
      request.error = true;
      const StepReport report = e.simulation->step(request);
      if (e.simulation->history.error_ratio.next == before || report.estimated_error <= report.residual) continue;
      if (report.error->distance < 0.1 * 1e-3 * e.simulation->traits.smallest_size) continue;
      if (e.simulation->history.fineness.parts > 1) continue;
      ++samples;
      EXPECT_GT(report.estimated_error, 0.5 * report.error->distance) << "step " << k;
      EXPECT_LT(report.estimated_error, 2 * report.error->distance) << "step " << k;
    }
    EXPECT_GE(samples, 2);
  }
}

// Looking at the error changes nothing, nor does it change what a sample finds.
TEST(Accuracy, IsNoMatterOfWhoLooks) {
  Experiment one(governed(pile(), 1e-2)), other(governed(pile(), 1e-2));
  StepRequest request;
  request.error = true;
  for (int k = 0; k < 40; ++k) {
    const double estimated = one.step().estimated_error;
    EXPECT_EQ(other.simulation->step(request).estimated_error, estimated);
  }
  EXPECT_GT(one.simulation->history.error_ratio.ratio, 0);
  EXPECT_EQ(state_hash(MPI_COMM_SELF, one.world()), state_hash(MPI_COMM_SELF, other.world()));
}

// A ball between jaws that close on it has no place to be. Its stage gives up long before the most iterations, and says so.
TEST(Accuracy, WhatCannotBeIsGivenUp) {
  for (const char* solver : {"accelerated_jacobi", "gauss_seidel"}) {
    SCOPED_TRACE(solver);
    Scene scene = scene_with(0.3);
    scene.gravity = Vec3::Zero();
    scene.solver.name = solver;
    scene.solver.recovery_speed = 0;
    for (const double side : {-1.0, 1.0}) {
      Body jaw = block(1, {0.2, 0.4, 0.4}, {side * 0.2, 0, 0});
      jaw.properties.motion = Motion::kinematic;
      jaw.state.velocity = {-side, 0, 0};
      add(scene, jaw);
    }
    add(scene, ball(1, 0.098, {0, 0, 0}));
    Experiment e(governed(std::move(scene), 1e-3));
    e.steps(5);
    EXPECT_FALSE(e.last.converged);
    EXPECT_LT(e.last.iterations, 0.6 * most_automatic_iterations * e.simulation->history.fineness.parts);
    EXPECT_GT(e.last.estimated_error, 1e-3 * 0.196);
  }
}

TEST(Accuracy, BelowWhatNumbersBearIsRefused) {
  Scene scene = scene_with(0.3);
  add(scene, ground());
  add(scene, ball(1, 0.5, {4095.5, 0, 0.5}));
  // Places reach 4096 m, of which 256 roundings come to 2^-32 m, of a ball of 1 m.
  Experiment fine(governed(scene, 2.4e-10));
  EXPECT_NO_THROW(check_accuracy(*fine.simulation));
  Experiment too_fine(governed(scene, 2.3e-10));
  try {
    check_accuracy(*too_fine.simulation);
    FAIL() << "it was not refused";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("key 'solver.accuracy': found 2.3e-10, expected at least 2.3e-10"),
              std::string::npos)
        << error.what();
  }
}

// Parts of a step are what as many substeps are.
TEST(Fineness, PartsAreSubsteps) {
  Scene scene = pile();
  Experiment parts(scene);
  parts.simulation->history.fineness.parts = 4;
  scene.time.substeps = 4;
  Experiment substeps(std::move(scene));
  parts.steps(40), substeps.steps(160);
  EXPECT_EQ(state_hash(MPI_COMM_SELF, parts.world()), state_hash(MPI_COMM_SELF, substeps.world()));
}

TEST(Fineness, FollowsTheDeepestContact) {
  const double allowed = 1;
  Fineness f;
  const auto after = [&](double deepest) { return (f = next_fineness(f, deepest, allowed)).parts; };
  EXPECT_EQ(after(0.9), 1);
  EXPECT_EQ(after(1.1), 2);
  EXPECT_EQ(after(1.1), 4);
  EXPECT_EQ(after(9), 4);                                 // the most
  for (int k = 0; k < 30; ++k) EXPECT_EQ(after(0.9), 4);  // neither deep nor calm
  for (int k = 0; k < 9; ++k) EXPECT_EQ(after(0.4), 4);
  EXPECT_EQ(after(0.4), 2);  // the tenth
  for (int k = 0; k < 9; ++k) EXPECT_EQ(after(0.4), 2);
  EXPECT_EQ(after(0.4), 1);
  EXPECT_EQ(after(0.4), 1);
  for (int k = 0; k < 25; ++k) EXPECT_GT(after(1.5), 1);
  for (int k = 0; k < 50; ++k) EXPECT_EQ(after(1.5), 1);  // finer steps have not helped
  after(0.8);
  EXPECT_EQ(after(1.5), 2);  // another one
}

}  // namespace unibody::small_worlds::accuracy_test
