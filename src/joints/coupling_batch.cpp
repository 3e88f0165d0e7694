#include "joints/coupling_batch.hpp"

#include <algorithm>
#include <cmath>

#include "joints/joint_types.hpp"

namespace unibody {

namespace {

JointRows<1> evaluate(std::uint8_t type, const JointEnd& a, const JointEnd& b) {
  JointRows<1> rows{};
  with_joint_type(type, [&]<class T>() {
    if constexpr (T::rows == 1) T::evaluate(a, b, rows);
  });
  return rows;
}

// How far a coordinate has moved; of an angle by less than half a turn.
double moved_by(std::uint8_t type, double from, double to) {
  return type == joint_type_index<Angle>() ? std::remainder(to - from, 2 * M_PI) : to - from;
}

}  // namespace

void CouplingBatch::for_each_tie(const BuildContext& context, const std::function<void(std::int32_t, std::span<const Slot>)>& f) {
  if (context.elements.joints == nullptr) return;
  const JointInput& input = *context.elements.joints;
  for (std::size_t i = 0; i < input.couplings.size() && i < input.couplings_here->size(); ++i) {
    std::array<Slot, 4> bodies = (*input.coupling_slots)[i].slots;  // each once: the joints of a gear share their carrier
    std::ranges::sort(bodies);
    const auto end = std::unique(bodies.begin(), bodies.end());
    const auto number = static_cast<std::size_t>((*input.couplings_here)[i]);
    f(input.couplings[number].colour, std::span<const Slot>(bodies.begin(), end));
  }
}

// P: what one unit of the multiplier changes the row by, of bodies that are at two ends by both.
double CouplingBatch::mobility_of(const Row& row, bool shared) {
  double sum = 0;
  for (std::size_t i = 0; i < row.ends.size(); ++i) {
    const auto is_same = [&](const End& end) { return end.side.slot == row.ends[i].side.slot; };
    if (std::find_if(row.ends.begin(), row.ends.end(), is_same) != row.ends.begin() + static_cast<std::ptrdiff_t>(i)) continue;
    Vec3 linear = Vec3::Zero(), angular = Vec3::Zero();
    for (const End& end : row.ends)
      if (is_same(end)) linear += end.linear, angular += end.angular;
    const JointSide& side = row.ends[i].side;
    sum += (shared ? side.share : 1) * (side.inverse_mass * linear.squaredNorm() + angular.dot(side.inverse_inertia * angular));
  }
  return sum;
}

void CouplingBatch::build(const BuildContext& context) {
  rows_.clear(), colour_end_.clear();
  if (context.elements.joints == nullptr || context.elements.joints->couplings.empty()) return;
  const JointInput& input = *context.elements.joints;
  step_ = context.state.step, stabilisation_ = context.state.stabilisation;
  const SolverBody still{};
  const std::int32_t colours = context.by_colour ? input.coupling_colours : 1;
  for (std::int32_t colour = 0; colour < colours; ++colour) {
    for (std::size_t i = 0; i < input.couplings_here->size(); ++i) {
      const Coupling& coupling = input.couplings[static_cast<std::size_t>((*input.couplings_here)[i])];
      if (context.by_colour && coupling.colour != colour) continue;
      if (input.is_broken(coupling.joints[0]) || input.is_broken(coupling.joints[1])) continue;
      const CouplingSlots& slots = (*input.coupling_slots)[i];
      Row row{};
      row.factor = {1, -coupling.ratio}, row.number = i, row.counted = slots.counted;
      for (std::size_t j = 0; j < 2; ++j) {
        const Joint& joint = input.joints[static_cast<std::size_t>(coupling.joints[j])];
        End &a = row.ends[2 * j], &b = row.ends[2 * j + 1];
        a.side = joint_side(context, joint, 0, slots.slots[2 * j]);
        b.side = joint_side(context, joint, 1, slots.slots[2 * j + 1]);
        row.types[j] = coordinate_of(joint.kind);
        const JointEnd end_a = end_of(a.side, still, 0), end_b = end_of(b.side, still, 0);
        const JointRows<1> at = evaluate(row.types[j], end_a, end_b);
        row.coordinate[j] = at.value[0];
        a.linear = row.factor[j] * at.linear[0], a.angular = row.factor[j] * at.angular[0];
        b.linear = -a.linear, b.angular = other_angular(a.linear, a.angular, end_a, end_b);
        if (j == 0) row.lever = turns_about_axis(joint.kind) ? joint.lever : 1;
      }
      row.mobility = mobility_of(row, false), row.shared_mobility = mobility_of(row, true);
      rows_.push_back(row);
    }
    colour_end_.push_back(rows_.size());
  }
}

void CouplingBatch::start_from(const History& history, const WarmStart& warm) {
  for (Row& row : rows_) {
    const auto& [impulse, first, second, constant, known] = history[row.number];
    if (known > 0) {
      row.coordinate[0] = first + moved_by(row.types[0], first, row.coordinate[0]);
      row.coordinate[1] = second + moved_by(row.types[1], second, row.coordinate[1]);
    }
    const double now = row.factor[0] * row.coordinate[0] + row.factor[1] * row.coordinate[1];
    row.constant = known > 0 ? constant : now;
    row.open = now - row.constant;
    row.lambda = row.y = warm.share * impulse;
  }
}

void CouplingBatch::remember(History& history, double) const {
  for (const Row& row : rows_) history[row.number] = {row.lambda, row.coordinate[0], row.coordinate[1], row.constant, 1};
}

void CouplingBatch::push(const Row& row, double impulse, std::span<Wrench> wrenches) {
  for (const End& end : row.ends) {
    Wrench& wrench = wrenches[static_cast<std::size_t>(end.side.slot)];
    add(wrench.force, impulse * end.linear), add(wrench.torque, impulse * end.angular);
  }
}

void CouplingBatch::add_impulses(SolveState& state, const WarmStart& warm, double) const {
  if (!(warm.share > 0)) return;
  for (const Row& row : rows_) push(row, row.lambda, state.wrenches);
}

double CouplingBatch::open_after(const Row& row, std::span<const SolverBody> bodies, bool as_it_is) const {
  double straight = 0, curved = 0, turn = 0;
  for (std::size_t j = 0; j < 2; ++j) {
    const End &a = row.ends[2 * j], &b = row.ends[2 * j + 1];
    const SolverBody &of_a = bodies[static_cast<std::size_t>(a.side.slot)], &of_b = bodies[static_cast<std::size_t>(b.side.slot)];
    straight += step_ * (a.linear.dot(velocity_of(of_a)) + a.angular.dot(spin_of(of_a)) + b.linear.dot(velocity_of(of_b)) +
                         b.angular.dot(spin_of(of_b)));
    turn = std::max({turn, spin_of(of_a).squaredNorm(), spin_of(of_b).squaredNorm()});
    if (stabilisation_ >= 0) continue;
    const double after = evaluate(row.types[j], end_of(a.side, of_a, step_), end_of(b.side, of_b, step_)).value[0];
    curved += row.factor[j] * moved_by(row.types[j], row.coordinate[j], after);
  }
  if (stabilisation_ >= 0) return straight + stabilisation_ * row.open;
  turn *= step_ * step_;
  const double part_of_curve = as_it_is ? 1 : std::min(1.0, most_turn_of_rows * most_turn_of_rows / turn);
  return row.open + straight + part_of_curve * (curved - straight);
}

void CouplingBatch::sweep(SolveState& state, const Extrapolation& extrapolation, SweepSums& sums) {
  const Update<double> update = update_of(extrapolation);
  for (Row& row : rows_) {
    if (!(row.shared_mobility > 0)) continue;
    const double r = open_after(row, state.bodies, false) / step_, by = -r / row.shared_mobility;
    SweepTerms<double> terms;
    const double moved = update.advance(row.lambda, row.y, row.y + by, by, r, -(r * by), step_ * row.lever * std::abs(r), terms);
    add_terms(sums, terms, row.counted);
    push(row, moved, state.wrenches);
  }
}

double CouplingBatch::relax(std::size_t colour, bool, SolveState& state) {
  double change = 0;
  for (std::size_t i = colour == 0 ? 0 : colour_end_[colour - 1]; i < colour_end_[colour]; ++i) {
    Row& row = rows_[i];
    if (!(row.mobility > 0)) continue;
    const double open = open_after(row, state.bodies, false), by = -open / (step_ * row.mobility);
    row.lambda += by;
    change = std::max(change, row.lever * std::abs(open));
    for (const End& end : row.ends) {
      SolverBody& body = state.bodies[static_cast<std::size_t>(end.side.slot)];
      const Vec3 v = by * end.side.inverse_mass * end.linear, w = by * (end.side.inverse_inertia * end.angular);
      for (int k = 0; k < 3; ++k) body.v[k] += v[k], body.w[k] += w[k];
    }
  }
  return change;
}

double CouplingBatch::residual(const SolveState& state) const {
  double worst = 0;
  for (const Row& row : rows_)
    if (row.mobility > 0) worst = std::max(worst, row.lever * std::abs(open_after(row, state.bodies, true)));
  return worst;
}

void CouplingBatch::for_each_residual(const SolveState& state, const ResidualVisitor& visit) const {
  for (const Row& row : rows_) {
    if (!(row.mobility > 0)) continue;
    std::array<Slot, 4> bodies;
    for (std::size_t k = 0; k < bodies.size(); ++k) bodies[k] = row.ends[k].side.slot;
    std::ranges::sort(bodies);
    const auto end = std::unique(bodies.begin(), bodies.end());
    visit(row.lever * std::abs(open_after(row, state.bodies, true)), std::span<const Slot>(bodies.begin(), end));
  }
}

}  // namespace unibody
