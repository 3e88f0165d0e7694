#include "constraints/constraint_batch.hpp"

#include <gtest/gtest.h>

#include "constraints/constraint_types.hpp"

namespace unibody {
namespace {

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
  const StepStart start{places, step};
  ConstraintBatch<Distance> batch;
  const std::vector<std::uint32_t> order{0}, groups{1};
  batch.build(
      std::span(&link, 1), order, groups, 2,
      [](std::uint32_t) {
        return std::array<Slot, 2>{0, 1};
      },
      [](std::uint32_t) { return true; });
  std::vector<Wrench> wrenches(3, Wrench{});
  SweepSums sums;
  batch.sweep_jacobi(start, bodies, wrenches, 0.5, sums);
  EXPECT_EQ(sums.largest, 0);
  EXPECT_EQ(sums.change, 0);
  EXPECT_EQ(batch.relax(0, start, bodies), 0);
  EXPECT_EQ(batch.residual(start, bodies), 0);

  bodies[1].v[0] = 0.1;  // now there is something to see
  batch.sweep_jacobi(start, bodies, wrenches, 0.5, sums);
  EXPECT_GT(sums.largest, 0);
  EXPECT_GT(batch.residual(start, bodies), 0);
}

}  // namespace
}  // namespace unibody
