// Friction that is larger at rest than in motion, against closed forms, with both solvers, at 1 and 4 substeps.
#include <gtest/gtest.h>

#include <cmath>

#include "small_worlds.hpp"

namespace unibody::small_worlds::stiction_test {

namespace {

constexpr double g = 9.81, mu = 0.4;

std::string head(const std::string& solver, int substeps, const std::string& material) {
  return "time: {substeps: " + std::to_string(substeps) + "}\nsolver: {tolerance: 1.0e-9, name: " + solver +
         "}\nmaterials: {m: {friction: 0.4, " + material + "}}\n";
}
// A horizontal ground stands for a slope whose tangent is 0.5: gravity is tilted towards x instead.
std::string slope() {
  const double sine = std::sqrt(0.2), cosine = 2 * sine;
  return "gravity: [" + std::to_string(g * sine) + ", 0, " + std::to_string(-g * cosine) + "]\n";
}
std::string box(const std::string& velocity) {
  return "bodies:\n  - {shape: {plane: {normal: [0, 0, 1]}}}\n  - {shape: {box: {size: [0.2, 0.2, 0.2]}}, mass: 2, "
         "position: [0, 0, 0.1], velocity: " +
         velocity + "}\n";
}

}  // namespace

class StictionOf : public testing::TestWithParam<std::tuple<const char*, int>> {};

// The slope's tangent is 0.5. The box's coefficient of friction is 0.6 at rest, so that it stays, and 0.4 in motion, so that it
// slides on once it moves.
TEST_P(StictionOf, HoldsWhatRestsAndNotWhatSlides) {
  const auto [solver, substeps] = GetParam();
  const std::string material = "stiction: 0.5";
  Experiment rests(scene_from_text(slope() + head(solver, substeps, material) + box("[0, 0, 0]"))),
      slides(scene_from_text(slope() + head(solver, substeps, material) + box("[0.5, 0, 0]"))),
      without(scene_from_text(slope() + head(solver, substeps, "restitution: 0") + box("[0, 0, 0]")));
  rests.seconds(5), slides.seconds(0.8), without.seconds(0.8);
  EXPECT_LT((rests.position(1) - Vec3(0, 0, 0.1)).norm(), 1e-4);
  const double gain = g * std::sqrt(0.2) * (1 - 2 * mu) * 0.8;  // of sin - mu cos
  EXPECT_NEAR(slides.velocity(1).x(), 0.5 + gain, 1e-5);
  EXPECT_NEAR(without.velocity(1).x(), gain, 1e-5);
}

// dv/dt = -mu g (1 + s exp(-v/c)) has the solution exp(v/c) + s = (exp(v0/c) + s) exp(-mu g t/c). The coefficient is that of the
// step's start: the error is of the first order in the step.
TEST_P(StictionOf, GrowsAsTheSlidingEnds) {
  const auto [solver, substeps] = GetParam();
  const double v0 = 1, c = 0.5, s = 0.5, t = 0.16;
  const double exact = c * std::log((std::exp(v0 / c) + s) * std::exp(-mu * g * t / c) - s);
  double last = 0;
  for (const int finer : {1, 4}) {
    Scene scene = scene_from_text(head(solver, substeps, "stiction: 0.5, stiction_speed: 0.5") + box("[1, 0, 0]"));
    scene.time.frame /= finer;
    Experiment run(std::move(scene));
    run.seconds(t);
    const double error = std::abs(run.velocity(1).x() - exact);
    EXPECT_LT(error, 0.2 * mu * g * run.h());
    EXPECT_NEAR(finer > 1 ? last / error : 1, finer, 0.4);
    last = error;
  }
}

// What lies on a belt rests where it goes along with it.
TEST_P(StictionOf, OnABelt) {
  const auto [solver, substeps] = GetParam();
  Experiment run(
      scene_from_text(slope() + head(solver, substeps, "stiction: 0.5") +
                      "bodies:\n  - {shape: {plane: {normal: [0, 0, 1]}}, surface_velocity: [-1, 0, 0]}\n"
                      "  - {shape: {box: {size: [0.2, 0.2, 0.2]}}, mass: 2, position: [0, 0, 0.1], velocity: [-1, 0, 0]}\n"));
  run.seconds(2);
  EXPECT_LT((run.position(1) - Vec3(-2, 0, 0.1)).norm(), 1e-4);
}

TEST_P(StictionOf, HoldsACloth) {
  const auto [solver, substeps] = GetParam();
  const std::string cloth =
      "bodies:\n  - {shape: {plane: {normal: [0, 0, 1]}}}\ncloths:\n  - {grid: {size: [0.5, 0.5], nodes: [6, 6]}, mass: 0.2, "
      "thickness: 0.02, links: {diagonals: both}, position: [0, 0, 0.01]}\n";
  const auto slid = [&](const std::string& material) {
    Experiment run(scene_from_text(slope() + head(solver, substeps, material) + cloth));
    const double start = run.position(15).x();
    run.seconds(0.8);
    return run.position(15).x() - start;
  };
  EXPECT_LT(std::abs(slid("stiction: 0.5")), 1e-3);
  EXPECT_NEAR(slid("restitution: 0"), 0.5 * g * std::sqrt(0.2) * (1 - 2 * mu) * 0.64, 0.03);
}

INSTANTIATE_TEST_SUITE_P(All, StictionOf,
                         testing::Combine(testing::Values("accelerated_jacobi", "gauss_seidel"), testing::Values(1, 4)));

// Of a pair that the scene lists, and of one that has the geometric means.
TEST(Stiction, OfPairs) {
  const Scene scene = scene_from_text(
      "materials: {a: {friction: 0.4, stiction: 0.2, stiction_speed: 0.01}, b: {friction: 0.4, stiction: 0.8, stiction_speed: "
      "0.04}, "
      "c: {friction: 1}, pairs: [{between: [a, c], stiction: 3}]}\n" +
      box("[0, 0, 0]"));
  EXPECT_DOUBLE_EQ(scene.pairs.of(PairValue::stiction, 0, 1), 0.4);
  EXPECT_DOUBLE_EQ(scene.pairs.of(PairValue::stiction_speed, 0, 1), 0.02);
  EXPECT_EQ(scene.pairs.of(PairValue::stiction, 2, 0), 3);
  EXPECT_EQ(scene.pairs.of(PairValue::stiction, 2, 2), 0);
  EXPECT_EQ(scene.pairs.of(PairValue::stiction_speed, 2, 2), 0.001);
}

}  // namespace unibody::small_worlds::stiction_test
