// Batches of constraints that have one row each: the base of kinds that say only where a row is and what it asks for.
//
// A row asks for c = 0 at the end of the step, with c = open + sum over its ends of (linear . dx + angular . dtheta)
// + compliance lambda / h. dx (m) and dtheta (rad) are what the body at an end moves and turns by in the step, (linear, angular)
// is the row's gradient there, and lambda is the multiplier: an impulse (N s, or N m s where c is an angle) along the gradient. A
// spring of stiffness k has the compliance 1 / k, a rigid tie has 0. r = c / h is the residual of the solvers.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <span>
#include <vector>

#include "constraints/batch.hpp"

namespace unibody {

// A body at one end of a row, in the step that the row is built for.
struct RowSide {
  Slot slot;
  double inverse_mass, share;  // 1/kg; how many constraints share the mass
  Mat3 inverse_inertia;        // 1/(kg m^2), world frame
};

inline RowSide row_side(const BuildContext& context, Slot slot) {
  const SolveState& state = context.state;
  const auto s = static_cast<std::size_t>(slot);
  const double share = state.counts.empty() ? 1 : std::max(1.0, context.settings.scaling * state.counts[s]);
  return {slot, state.bodies[s].inverse_mass, share, inverse_inertia_of(state.bodies, state.inertia, state.isotropic, s)};
}

inline Vec3 velocity_of(const SolverBody& body) { return {body.v[0], body.v[1], body.v[2]}; }  // m/s
inline Vec3 spin_of(const SolverBody& body) { return {body.w[0], body.w[1], body.w[2]}; }      // rad/s
inline void add(Vec4d& to, const Vec3& x) { to += Vec4d{x.x(), x.y(), x.z(), 0}; }

template <class Side = RowSide>
struct RowEnd {
  Side side;
  Vec3 linear, angular;  // the gradient of c by the body's place and by its turn
};

template <std::size_t ends_of_row, class Side = RowSide>
struct Row {
  std::array<RowEnd<Side>, ends_of_row> ends;
  double open = 0;        // c at the start of the step
  double compliance = 0;  // m/N, or rad/(N m)
  double lever = 1;       // m, what one unit of c counts as where residuals of all kinds are compared
  std::int32_t colour = 0;
  bool counted = true;  // this rank counts the row in sums over all ranks

  // What the batch adds.
  std::size_t number = 0;                    // of the constraint, among those that are here
  double mobility = 0, shared_mobility = 0;  // P, what one unit of lambda changes r by; and with the bodies' shares (Jacobi)
  double lambda = 0, y = 0;                  // the multiplier, and its extrapolation
};

// Kind derives from this and has, beside its name,
//   for_each_element(elements, f): calls f(key, ids of the bodies) for each constraint that touches a home body (see KeyedBatch);
//   row_of(context, key, number): the row of such a constraint in the step, or nothing where it does not act.
// What else stands here, a kind may have in a way of its own. Kinds of which two constraints on different ranks can have a body
// in common need colours_of() and for_each_stencil() with the colours that keep them apart.
template <class Kind, class RowOfKind>
class RowBatch : public BatchDefaults {
 public:
  using History = std::vector<std::array<double, 1>>;  // the impulse of each constraint that is here
  using Key = std::array<Id, 1>;                       // the constraint's number, over all ranks

  static std::int32_t colours_of(const BuildContext&) { return 1; }  // over all ranks

  template <class F>
  static void for_each_stencil(const BuildContext& context, F&& f) {
    Kind::for_each_element(context.elements, [&](const auto&, std::span<const Id> ids) {
      std::vector<Slot> slots;
      for (const Id id : ids) slots.push_back(context.world.find(id));
      f(0, std::span<const Slot>(slots));
    });
  }
  static void count(const BuildContext& context, std::span<std::int32_t> counts) { count_stencils<Kind>(context, counts); }

  void build(const BuildContext& context) {
    rows_.clear();
    step_ = context.state.step, stabilisation_ = context.state.stabilisation;
    std::size_t number = 0;
    Kind::for_each_element(context.elements, [&](const auto& key, std::span<const Id>) {
      if (std::optional<RowOfKind> row = Kind::row_of(context, key, number)) {
        row->number = number;
        row->mobility = mobility_of(*row, false), row->shared_mobility = mobility_of(*row, true);
        rows_.push_back(*row);
      }
      ++number;
    });
    if (context.by_colour) std::ranges::stable_sort(rows_, {}, &RowOfKind::colour);
    const std::int32_t colours = context.by_colour ? Kind::colours_of(context) : std::min(1, Kind::colours_of(context));
    colour_end_.assign(static_cast<std::size_t>(colours), rows_.size());
    for (std::int32_t c = 0; c + 1 < colours; ++c)
      colour_end_[static_cast<std::size_t>(c)] =
          static_cast<std::size_t>(std::ranges::upper_bound(rows_, c, {}, &RowOfKind::colour) - rows_.begin());
  }

  std::size_t colours() const { return colour_end_.size(); }

  void sweep(SolveState& state, const Extrapolation& extrapolation, SweepSums& sums) {
    const Update<double> update = update_of(extrapolation);
    swept_ = true;
    for (RowOfKind& row : rows_) {
      if (!(row.shared_mobility > 0)) continue;
      const double r = kind().open_after(row, state.bodies, false) / step_, by = -r / row.shared_mobility;
      SweepTerms<double> terms;
      const double moved =
          update.advance(row.lambda, row.y, row.y + by, by, r, -(r * by), step_ * row.lever * std::abs(r), terms);
      add_terms(sums, terms, row.counted);
      push(row, moved, state.wrenches);
    }
  }

  double relax(std::size_t colour, bool, SolveState& state) {
    double change = 0;
    swept_ = false;
    for (std::size_t i = colour == 0 ? 0 : colour_end_[colour - 1]; i < colour_end_[colour]; ++i) {
      RowOfKind& row = rows_[i];
      if (!(row.mobility > 0)) continue;
      const double open = kind().open_after(row, state.bodies, false), by = -open / (step_ * row.mobility);
      row.lambda += by;
      change = std::max(change, row.lever * std::abs(open));
      for (const auto& end : row.ends) {
        SolverBody& body = state.bodies[static_cast<std::size_t>(end.side.slot)];
        const Vec3 v = by * end.side.inverse_mass * end.linear, w = by * (end.side.inverse_inertia * end.angular);
        for (int k = 0; k < 3; ++k) body.v[k] += v[k], body.w[k] += w[k];
      }
    }
    return change;
  }

  template <class F>
  void for_each_unknown(F&& f) {
    for (RowOfKind& row : rows_) f(std::span(&row.lambda, 1));
  }

  double residual(const SolveState& state) const {
    double worst = 0;
    for (const RowOfKind& row : rows_)
      if (row.mobility > 0) worst = std::max(worst, row.lever * std::abs(kind().open_after(row, state.bodies, true)));
    return worst;
  }
  void for_each_residual(const SolveState& state, const ResidualVisitor& visit) const {
    for (const RowOfKind& row : rows_) {
      if (!(row.mobility > 0)) continue;
      std::array<Slot, std::tuple_size_v<decltype(row.ends)>> bodies;
      for (std::size_t k = 0; k < bodies.size(); ++k) bodies[k] = row.ends[k].side.slot;
      std::ranges::sort(bodies);
      const auto end = std::unique(bodies.begin(), bodies.end());
      visit(row.lever * std::abs(kind().open_after(row, state.bodies, true)), std::span<const Slot>(bodies.begin(), end));
    }
  }

  void start_from(const History& history, const WarmStart& warm) {
    for (RowOfKind& row : rows_) row.lambda = row.y = row.number < history.size() ? warm.share * history[row.number][0] : 0;
  }
  void add_impulses(SolveState& state, const WarmStart& warm, double) const {
    if (!(warm.share > 0)) return;
    for (const RowOfKind& row : rows_) push(row, row.lambda, state.wrenches);
  }
  void remember(History& history, double) const {
    for (const RowOfKind& row : rows_) history.at(row.number)[0] = row.lambda;
  }
  std::size_t bytes() const { return rows_.capacity() * sizeof(RowOfKind); }

 protected:
  // c at the end of the step, with the bodies' velocities and the multiplier that belongs to them. A kind whose c is curved has
  // its own; as_it_is: for a residual, without what an iteration leaves out of the curve.
  double open_after(const RowOfKind& row, std::span<const SolverBody> bodies, bool) const {
    double open = row.open + row.compliance * (swept_ ? row.y : row.lambda) / step_;
    for (const auto& end : row.ends) {
      const SolverBody& body = bodies[static_cast<std::size_t>(end.side.slot)];
      open += step_ * (end.linear.dot(velocity_of(body)) + end.angular.dot(spin_of(body)));
    }
    return open;
  }

  std::vector<RowOfKind> rows_;
  double step_ = 0.016, stabilisation_ = -1;

 private:
  const Kind& kind() const { return static_cast<const Kind&>(*this); }

  // P; of a body that is at two ends, by both.
  double mobility_of(const RowOfKind& row, bool shared) const {
    double sum = row.compliance / (step_ * step_);
    for (std::size_t i = 0; i < row.ends.size(); ++i) {
      const auto is_same = [&](const auto& end) { return end.side.slot == row.ends[i].side.slot; };
      if (std::find_if(row.ends.begin(), row.ends.end(), is_same) != row.ends.begin() + static_cast<std::ptrdiff_t>(i)) continue;
      Vec3 linear = Vec3::Zero(), angular = Vec3::Zero();
      for (const auto& end : row.ends)
        if (is_same(end)) linear += end.linear, angular += end.angular;
      const auto& side = row.ends[i].side;
      sum += (shared ? side.share : 1) * (side.inverse_mass * linear.squaredNorm() + angular.dot(side.inverse_inertia * angular));
    }
    return sum;
  }
  static void push(const RowOfKind& row, double impulse, std::span<Wrench> wrenches) {
    for (const auto& end : row.ends) {
      Wrench& wrench = wrenches[static_cast<std::size_t>(end.side.slot)];
      add(wrench.force, impulse * end.linear), add(wrench.torque, impulse * end.angular);
    }
  }

  std::vector<std::size_t> colour_end_;
  bool swept_ = true;  // by the Jacobi solvers, in which the bodies' velocities belong to y; else to lambda
};

}  // namespace unibody
