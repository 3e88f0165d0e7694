// Rolling and spinning friction: torques that resist how two touching bodies turn against each other, about the tangents of
// their contact and about its normal.
//
// Rows of a manifold, rad/s: r = w.n, w.s, w.t, with w the angular velocity of one body against the other's. Unknowns are
// angular impulses (N m s), bounded by the manifold's normal impulses N, summed over its points, at every iteration anew:
//   |tau_n| <= spinning N,  |(tau_s, tau_t)| <= rolling N
// with coefficients in metres: the arm at which the normal force meets the ground ahead of the centre. As friction, it is the
// same in both stages, each with its own N, whose bounds add up. It starts from a share of the last step's torques: from
// nothing, what is held would creep by what each step leaves undone.
// Scales are absolute row sums of the manifold's 3 x 3 block, masses split by the bodies' counts with the Jacobi solvers, where
// such a manifold counts twice: once for its contact, once for these rows.
#pragma once

#include <array>
#include <memory_resource>
#include <span>
#include <string_view>
#include <vector>

#include "constraints/contact_batch.hpp"

namespace unibody {

class RollingBatch : public BatchDefaults {
 public:
  static constexpr std::string_view name = "rolling_friction";
  static constexpr std::string_view history_columns = "torque[3] (N m, world frame, on the first body)";
  using History = PairHistory<3>;
  static constexpr bool in_velocity_stage = true, in_free_islands = true, follows = true;

  explicit RollingBatch(std::pmr::memory_resource* memory = std::pmr::get_default_resource()) : rows_(memory) {}

  // Manifolds that resist rolling or spinning, ascending.
  template <class F>
  static void for_each_stencil(const BuildContext& context, F&& f) {
    for_each_resisting(context, [&](std::uint32_t, const Manifold& m, double, double) {
      f(0, std::span<const Slot>(std::array{m.slot_a, m.slot_b}));
    });
  }
  static void count(const BuildContext& context, std::span<std::int32_t> counts) {
    count_stencils<RollingBatch>(context, counts);
  }

  // Lays them out as the batch of the contacts, built before, has laid out its manifolds, whose normal multipliers are the bound.
  void build(const BuildContext& context);

  std::size_t colours() const { return group_end_.size(); }
  bool needs_all(std::size_t) const { return false; }

  // After a sweep, or a pass over the same colour, of the contacts.
  void sweep(SolveState& state, const Extrapolation& extrapolation, SweepSums& sums);
  double relax(std::size_t colour, bool backwards, SolveState& state);
  template <class F>
  void for_each_unknown(F&& f) {
    for (Row& row : rows_) f(std::span<double>(row.lambda));
  }

  void keep_impulses(bool together);
  void join_stages();

  void start_from(const History& history, const WarmStart& warm);
  void add_impulses(SolveState& state, const WarmStart& warm, double) const;
  void remember(History& history, double leak) const;

  // An angle counts by the longer arm from the bodies' centres to the contact.
  double residual(const SolveState& state) const;
  void for_each_residual(const SolveState& state, const ResidualVisitor& visit) const;

  std::size_t bytes() const { return 0; }  // in the solve's scratch memory, which is counted as a whole

 private:
  using Torque = std::array<double, 3>;  // N m s, about n, s and t
  struct Row {
    std::uint32_t block, lane, manifold;
    bool counted;
    Slot a, b;
    Id id_a, id_b;
    bool first;                       // of its pair's manifolds
    bool remembered;                  // as its contact is
    double rolling, spinning, lever;  // m
    std::array<Vec3, 3> axes;         // n, s, t
    Vec3 aim;                         // rad/s, how a turns against b where neither rolls: as their surfaces move
    Mat3 turn_a, turn_b;              // 1/(kg m^2), inverse inertia, world frame
    std::array<double, 2> scale;      // 1/(kg m^2), of the spinning row and the rolling ones; 0: neither body can turn so
    std::array<double, 2> own_scale;  // without the split of masses
    Torque lambda, y, kept;
  };
  static std::array<double, 2> scale_of(const Row& row, double share_a, double share_b);
  static Torque rates(const Row& row, std::span<const SolverBody> bodies);
  Torque project_step(const Row& row, const std::array<double, 2>& scale, const Torque& from, const Torque& rates) const;
  double residual_of(const Row& row, std::span<const SolverBody> bodies) const;  // m/s; 0 where it is not selected
  static Vec3 torque_of(const Row& row, const Torque& lambda);

  // f(number of the manifold, manifold, coefficient of rolling, of spinning (m))
  template <class F>
  static void for_each_resisting(const BuildContext& context, F&& f);
  // Whether friction acts in the solve, and any pair of materials resists.
  static bool may_act(const BuildContext& context);
  static double resistance(const BuildContext& context, PairValue value, const Manifold& m);  // m

  std::pmr::vector<Row> rows_;
  const ContactBatch* contacts_ = nullptr;
  std::vector<std::size_t> group_end_;
  double step_ = 0.016;
  enum class Kept { nothing, apart, together } kept_ = Kept::nothing;  // as ContactBatch's
};

template <class F>
void RollingBatch::for_each_resisting(const BuildContext& context, F&& f) {
  if (!may_act(context)) return;
  const auto& manifolds = context.contacts->manifolds;
  for (std::uint32_t m = 0; m < manifolds.size(); ++m) {
    const double rolling = resistance(context, PairValue::rolling, manifolds[m]);
    const double spinning = resistance(context, PairValue::spinning, manifolds[m]);
    if (rolling > 0 || spinning > 0) f(m, manifolds[m], rolling, spinning);
  }
}

}  // namespace unibody
