#include "constraints/constraint_batch.hpp"

#include <gtest/gtest.h>

#include <numeric>

#include "constraints/constraint_types.hpp"

namespace unibody::constraint_batch_test {
namespace {

std::vector<Vec4d> moved(std::span<const Vec4d> places, std::span<const SolverBody> bodies, double step) {
  std::vector<Vec4d> result(places.begin(), places.end());
  for (std::size_t i = 0; i < result.size(); ++i)
    for (std::size_t k = 0; k < 3; ++k) result[i][k] += step * bodies[i].v[k];
  return result;
}

// Blocks have four lanes. How many of them are empty depends on how constraints fall on ranks, so it must not show in any sum:
// one soft link at rest leaves three lanes, which are tied to nobody and far from their rest length.
TEST(ConstraintBatch, EmptyLanesShowInNoSum) {
  Constraint<Distance> link;
  link.ids = {0, 1};
  link.parameters = {2}, link.compliance = {1e-3}, link.damping = 0.01;
  const double step = 0.01;
  std::vector<SolverBody> bodies(3, SolverBody{});
  bodies[0].inverse_mass = bodies[1].inverse_mass = 1;
  const std::vector<Vec4d> places{Vec4d{0, 0, 0, 1}, Vec4d{2, 0, 0, 1}, Vec4d{0, 0, 0, 0}};
  const auto start = [&](std::span<const Vec4d> moved = {}) { return StepStart{places, step, moved}; };
  ConstraintBatch<Distance> batch;
  const std::vector<std::uint32_t> order{0}, groups{1};
  batch.lay_out(
      std::span(&link, 1), order, groups, 2, Form::incremental,
      [](std::uint32_t) {
        return std::array<Slot, 2>{0, 1};
      },
      [](std::uint32_t) { return true; });
  std::vector<Vec4d> impulses(3, Vec4d{});
  SweepSums sums;
  std::vector<Vec4d> now = moved(places, bodies, step);
  batch.sweep(start(now), bodies, impulses, {0.5}, sums);
  EXPECT_EQ(sums.largest, 0);
  EXPECT_EQ(sums.change, 0);
  EXPECT_EQ(batch.relax(0, start(), bodies), 0);
  EXPECT_EQ(batch.residual(start(), bodies), 0);

  bodies[1].v[0] = 0.1;  // now there is something to see
  now = moved(places, bodies, step);
  batch.sweep(start(now), bodies, impulses, {0.5}, sums);
  EXPECT_GT(sums.largest, 0);
  EXPECT_GT(batch.residual(start(), bodies), 0);
}

// The residual of a damped constraint is |c + rho dc/dt| in metres, however large the damping rho is. The verdict on a step and
// the stop tests of both kinds of solver see the same number.
TEST(ConstraintBatch, DampingDoesNotHideTheResidual) {
  constexpr double step = 0.01, speed = 0.3;
  const std::vector<Vec4d> places{Vec4d{0, 0, 0, 1}, Vec4d{2.1, 0, 0, 1}, Vec4d{0, 0, 0, 0}};
  const auto start = [&](std::span<const Vec4d> moved = {}) { return StepStart{places, step, moved}; };
  for (const double damping : {0.0, 0.01, 1.0, 100.0}) {
    Constraint<Distance> link;
    link.ids = {0, 1}, link.parameters = {2}, link.compliance = {1e-3}, link.damping = damping;
    std::vector<SolverBody> bodies(3, SolverBody{});
    bodies[0].inverse_mass = bodies[1].inverse_mass = 1, bodies[1].v[0] = speed;
    const std::vector<std::uint32_t> order{0}, groups{1};
    ConstraintBatch<Distance> batch;
    batch.lay_out(
        std::span(&link, 1), order, groups, 2, Form::incremental,
        [](std::uint32_t) {
          return std::array<Slot, 2>{0, 1};
        },
        [](std::uint32_t) { return true; });
    const double expected = 0.1 + step * speed + damping * speed;
    std::vector<Vec4d> impulses(3, Vec4d{});
    SweepSums sums;
    const std::vector<Vec4d> now = moved(places, bodies, step);
    batch.sweep(start(now), bodies, impulses, {}, sums);
    EXPECT_NEAR(sums.change, expected, 1e-12 * expected) << damping;
    batch.lay_out(
        std::span(&link, 1), order, groups, 2, Form::incremental,
        [](std::uint32_t) {
          return std::array<Slot, 2>{0, 1};
        },
        [](std::uint32_t) { return true; });
    EXPECT_NEAR(batch.residual(start(), bodies), expected, 1e-12 * expected) << damping;
    EXPECT_NEAR(batch.relax(0, start(), bodies), expected, 1e-12 * expected) << damping;
  }
}

// A warm start takes of an old multiplier no more than has a geometric stiffness of h lambda (w_0 + w_1) / l, in tension and in
// compression, and all of one that has less.
TEST(ConstraintBatch, AWarmStartBoundsTheGeometricStiffnessOfLinks) {
  constexpr double step = 0.01, most = 3, length = 0.5;
  const std::vector<Vec4d> places{Vec4d{0, 0, 0, 2}, Vec4d{length, 0, 0, 6}, Vec4d{0, 0, 0, 0}};
  const std::vector<SolverBody> bodies(3, SolverBody{});
  Constraint<Distance> link;
  link.ids = {0, 1}, link.parameters = {0.4};
  ConstraintBatch<Distance> batch;
  const std::vector<std::uint32_t> order{0}, groups{1};
  batch.lay_out(
      std::span(&link, 1), order, groups, 2, Form::incremental,
      [](std::uint32_t) {
        return std::array<Slot, 2>{0, 1};
      },
      [](std::uint32_t) { return true; });
  const double bound = most * length / (step * (2 + 6));  // N s
  const auto applied = [&](double multiplier, double stiffness) {
    const std::array<double, 1> old{multiplier};
    EXPECT_DOUBLE_EQ(batch.geometric_stiffness({places, step}, std::span(&old, 1)), step * std::abs(multiplier) * (2 + 6) / 0.4);
    batch.set_multipliers(std::span(&old, 1));
    std::vector<Vec4d> impulses(3, Vec4d{});
    batch.add_impulses({places, step}, bodies, impulses, stiffness);
    std::array<double, 1> kept{};
    batch.get_multipliers(std::span(&kept, 1));
    EXPECT_DOUBLE_EQ(impulses[0][0], -kept[0]);  // towards the other end where the multiplier pulls
    EXPECT_DOUBLE_EQ(impulses[1][0], kept[0]);
    return kept[0];
  };
  for (const double sign : {-1., 1.}) {
    EXPECT_DOUBLE_EQ(applied(sign * 10 * bound, most), sign * bound);
    EXPECT_DOUBLE_EQ(applied(sign * 0.9 * bound, most), sign * 0.9 * bound);
    EXPECT_DOUBLE_EQ(applied(sign * 10 * bound, HUGE_VAL), sign * 10 * bound);
  }
}

// Whether a rank has soft constraints beside stiff ones must not show in the stiff ones' bits.
TEST(ConstraintBatch, AStiffConstraintIsTheSameBesideASoftOne) {
  std::vector<Constraint<Distance>> links(2);
  links[0].ids = {0, 1}, links[0].parameters = {1.9};
  links[1].ids = {2, 3}, links[1].parameters = {0.7}, links[1].compliance = {1e-3}, links[1].damping = 0.01;
  const std::vector<Vec4d> places{Vec4d{0.1, 0, 0, 3}, Vec4d{2, 0.3, 0, 7}, Vec4d{0, 5, 0, 2}, Vec4d{1, 5, 0, 1},
                                  Vec4d{0, 0, 0, 0}};
  const auto forces = [&](std::size_t count) {
    std::vector<SolverBody> bodies(5, SolverBody{});
    for (std::size_t i = 0; i < 4; ++i) bodies[i].inverse_mass = places[i][3], bodies[i].v[0] = 0.37 * static_cast<double>(i);
    std::vector<std::uint32_t> order(count);
    std::iota(order.begin(), order.end(), 0);
    const std::vector<std::uint32_t> groups{static_cast<std::uint32_t>(count)};
    ConstraintBatch<Distance> batch;
    batch.lay_out(
        std::span(links).first(count), order, groups, 4, Form::incremental,
        [](std::uint32_t i) {
          return std::array<Slot, 2>{static_cast<Slot>(2 * i), static_cast<Slot>(2 * i + 1)};
        },
        [](std::uint32_t) { return true; });
    std::vector<double> found;
    for (int k = 0; k < 5; ++k) {
      std::vector<Vec4d> impulses(5, Vec4d{});
      SweepSums sums;
      const auto now = moved(places, bodies, 0.007);
      batch.sweep({places, 0.007, now}, bodies, impulses, {0.3, 0.2}, sums);
      for (int d = 0; d < 3; ++d) {
        bodies[0].v[d] += bodies[0].inverse_mass * impulses[0][static_cast<std::size_t>(d)];
        found.push_back(impulses[0][static_cast<std::size_t>(d)]);
      }
    }
    return found;
  };
  EXPECT_EQ(forces(1), forces(2));
  EXPECT_NE(forces(1)[0], 0);
}

}  // namespace
}  // namespace unibody::constraint_batch_test
