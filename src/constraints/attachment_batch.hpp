// Nodes tied to points of dynamic bodies: three rows each, along the world's axes, without a cone to lie in.
//
// r = gap / h + u, u the velocity at which the body's point leaves the node; linear in the step, so that at the end of a solve
// the gap that is left is of second order in the body's turn. A row's scale is the whole block of its attachment, masses split by
// the bodies' counts: a bound from above, as the other constraints have it. Both ends are pushed at the node's place, so that
// momentum and angular momentum are kept. All rows of a step move at once, for every solver; they start from zero.
#pragma once

#include <memory_resource>
#include <span>
#include <vector>

#include "constraints/system.hpp"
#include "core/types.hpp"

namespace unibody {

// An attachment as one step sees it, in the world's axes.
struct AttachedNode {
  Slot body, node;
  Vec3 arm;  // m, from the body's centre to the node
  Vec3 gap;  // m, from the node to the point of the body where it belongs
};

class AttachmentBatch {
 public:
  explicit AttachmentBatch(std::pmr::memory_resource* memory = std::pmr::get_default_resource()) : rows_(memory) {}

  // counts: how many constraints share each slot's mass; scaling: factor on them; step: s. An attachment is counted in sums over
  // all ranks where its body is one of the first `homes`.
  void build(std::span<const AttachedNode> attached, std::span<const SolverBody> bodies, std::span<const InverseInertia> inertia,
             std::span<const std::uint8_t> isotropic, std::span<const std::int32_t> counts, double scaling, double step,
             std::size_t homes);

  // One Jacobi sweep, as ConstraintBatch's.
  void sweep_jacobi(std::span<const SolverBody> bodies, std::span<Wrench> wrenches, const Extrapolation& beyond, SweepSums& sums);

  // Natural residual (m): the largest component of h r.
  double residual(std::span<const SolverBody> bodies) const;

 private:
  struct Row {
    Slot body, node;
    bool counted;
    Vec3 arm, bias;  // m, m/s
    Mat3 inverse;    // kg, of the scaled block
    Vec3 lambda, y;  // N s, multiplier and its extrapolation
  };
  static Vec3 defect(const Row& row, std::span<const SolverBody> bodies);

  std::pmr::vector<Row> rows_;
  double step_ = 0.016;
};

}  // namespace unibody
