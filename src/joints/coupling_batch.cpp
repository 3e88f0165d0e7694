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
  return type == joint_type_index<Angle>() ? wrapped(to - from) : to - from;
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

std::int32_t CouplingBatch::colours_of(const BuildContext& context) {
  const JointInput* input = context.elements.joints;
  return input == nullptr || input->couplings.empty() ? 0 : input->coupling_colours;
}

std::optional<CouplingRow> CouplingBatch::row_of(const BuildContext& context, const Key& key, std::size_t number) {
  const JointInput& input = *context.elements.joints;
  const Coupling& coupling = input.couplings[static_cast<std::size_t>(key[0])];
  if (input.is_broken(coupling.joints[0]) || input.is_broken(coupling.joints[1])) return std::nullopt;
  const CouplingSlots& slots = (*input.coupling_slots)[number];
  const SolverBody still{};
  CouplingRow row{};
  row.factor = {1, -coupling.ratio}, row.colour = coupling.colour, row.counted = slots.counted;
  for (std::size_t j = 0; j < 2; ++j) {
    const Joint& joint = input.joints[static_cast<std::size_t>(coupling.joints[j])];
    RowEnd<JointSide>&a = row.ends[2 * j], &b = row.ends[2 * j + 1];
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
  return row;
}

void CouplingBatch::start_from(const History& history, const WarmStart& warm) {
  for (CouplingRow& row : rows_) {
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
  for (const CouplingRow& row : rows_) history[row.number] = {row.lambda, row.coordinate[0], row.coordinate[1], row.constant, 1};
}

double CouplingBatch::open_after(const CouplingRow& row, std::span<const SolverBody> bodies, bool as_it_is) const {
  double straight = 0, curved = 0, turn = 0;
  for (std::size_t j = 0; j < 2; ++j) {
    const RowEnd<JointSide>&a = row.ends[2 * j], &b = row.ends[2 * j + 1];
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

}  // namespace unibody
