// Nodes tied to points of dynamic bodies: three rows each, along the world's axes, without a cone to lie in.
//
// r = gap / h + u, u the mean velocity over the step at which the body's point leaves the node: that at its start, and what the
// point's circle adds with the spin that is predicted. The rows are linear in the velocities. At the end of a solve the gap that
// is left is of second order in what the step changes of the body's turn. A row's scale is the whole block of its attachment,
// masses split by the bodies' counts: a bound from above, as the other constraints have it. Both ends are pushed at the node's
// place, so that momentum and angular momentum are kept. All rows of a step move at once, for every solver. They start from the
// same share of their old multipliers as the links and elements that they balance. If attachments started from a smaller share,
// the old tension of a thread would pull the attached node away from its body at the start of each step, and the thread would
// throw a heavy body up.
#pragma once

#include <array>
#include <memory_resource>
#include <span>
#include <string_view>
#include <vector>

#include "constraints/batch.hpp"
#include "core/types.hpp"

namespace unibody {

// An attachment as one step sees it, in the world's axes.
struct AttachedNode {
  std::array<Id, 2> ids;  // of the node and the body
  Slot body, node;
  Vec3 arm;  // m, from the body's centre to the node
  Vec3 gap;  // m, from the node to the point of the body where it belongs
};

class AttachmentBatch : public BatchDefaults {
 public:
  using History = std::vector<std::array<double, 3>>;  // N s, on the body; of each attachment that is here, 0 of released ones
  using Key = std::array<Id, 2>;                       // ids of the node and the body
  static constexpr std::string_view name = "attachments";
  static constexpr bool pushes_wrenches = true;

  explicit AttachmentBatch(std::pmr::memory_resource* memory = std::pmr::get_default_resource()) : rows_(memory) {}

  template <class F>
  static void for_each_element(const Elements& elements, F&& f) {
    for (const Key& key : elements.attachments) f(key, std::span<const Id>(key));
  }

  template <class F>
  static void for_each_stencil(const BuildContext& context, F&& f) {
    for (const AttachedNode& a : context.attached) f(0, std::span<const Slot>(std::array{a.body, a.node}));
  }
  static void count(const BuildContext& context, std::span<std::int32_t> counts) {
    count_stencils<AttachmentBatch>(context, counts);
  }

  // With Gauss-Seidel they share masses among themselves alone. An attachment is counted in sums over all ranks where its body is
  // home.
  void build(const BuildContext& context);

  std::size_t colours() const { return any_ ? 1 : 0; }
  void sweep(SolveState& state, const Extrapolation& extrapolation, SweepSums& sums);
  double relax(std::size_t colour, bool backwards, SolveState& state);
  template <class F>
  void for_each_unknown(F&& f) {
    for (Row& row : rows_) f(std::span(row.lambda.data(), 3));
  }
  double residual(const SolveState& state) const;  // the largest component of h r
  void for_each_residual(const SolveState& state, const ResidualVisitor& visit) const;
  std::size_t bytes() const { return 0; }  // in the solve's scratch memory, which is counted as a whole

  void start_from(const History& history, const WarmStart& warm);
  void add_impulses(SolveState& state, const WarmStart& warm, double) const;
  void add_applied(const SolveState& state, std::span<Vec4d> impulses) const;
  void remember(History& history, double) const;

 private:
  struct Row {
    std::size_t number;  // in the history
    Slot body, node;
    bool counted;
    Vec3 arm, bias;  // m, m/s
    Mat3 inverse;    // kg, of the scaled block
    Vec3 lambda, y;  // N s, multiplier and its extrapolation
  };
  static Vec3 defect(const Row& row, std::span<const SolverBody> bodies);

  std::pmr::vector<Row> rows_;
  double step_ = 0.016;
  bool any_ = false;  // the scene has any
};

}  // namespace unibody
