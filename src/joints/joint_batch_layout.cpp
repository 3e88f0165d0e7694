// JointBatch: which rows stand for which joints, and in which order.
#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "joints/joint_batch.hpp"
#include "joints/joint_types.hpp"
#include "joints/semidefinite.hpp"

namespace unibody {

void JointBatch::for_each_tie(const BuildContext& context, const std::function<void(std::int32_t, std::span<const Slot>)>& f) {
  if (context.elements.joints == nullptr) return;
  const std::span<const Joint> joints = context.elements.joints->joints;
  const JointList& list = *context.elements.joints->list;
  const std::vector<JointSlots>& slots = *context.elements.joints->slots;
  const auto is_home = [&](Slot s) { return static_cast<std::size_t>(s) < context.world.homes; };
  std::map<std::int32_t, std::vector<Slot>> trees;
  for (std::size_t i = 0; i < list.size(); ++i) {
    const Joint& joint = joints[static_cast<std::size_t>(list[i])];
    const std::array ends{slots[i].a, slots[i].b};
    if (is_home(ends[0]) || is_home(ends[1])) f(joint.colour, ends);  // else it is here for its tree alone
    if (joint.tree >= 0) trees[joint.tree].insert(trees[joint.tree].end(), ends.begin(), ends.end());
  }
  for (auto& [tree, bodies] : trees) {
    std::sort(bodies.begin(), bodies.end());
    bodies.erase(std::unique(bodies.begin(), bodies.end()), bodies.end());
    f(-1, bodies);
  }
}

void JointBatch::count(const BuildContext& context, std::span<std::int32_t> counts) {
  if (context.elements.joints == nullptr) return;
  const std::span<const Joint> joints = context.elements.joints->joints;
  const JointList& list = *context.elements.joints->list;
  const std::vector<JointSlots>& slots = *context.elements.joints->slots;
  std::vector<std::uint8_t> in_tree(counts.size(), 0);
  for (std::size_t i = 0; i < list.size(); ++i) {
    if (context.elements.joints->is_broken(list[i])) continue;
    const Joint& joint = joints[static_cast<std::size_t>(list[i])];
    const std::int32_t beside = (joint.is_limited() ? 1 : 0) + (joint.has_cone() ? 1 : 0) + (joint.motor != Motor::none ? 1 : 0) +
                                (joint.friction > 0 ? 1 : 0) + (joint.is_sprung() ? 1 : 0);
    for (const Slot slot : {slots[i].a, slots[i].b}) {
      const auto s = static_cast<std::size_t>(slot);
      counts[s] += beside;
      if (joint.tree < 0 || !in_tree[s]) ++counts[s];
      if (joint.tree >= 0) in_tree[s] = 1;
    }
  }
}

namespace {

// rad/s, at which a body with a joint turns in a step of this length (s) by `speed` times it: q + h/2 (w q), made a unit
// quaternion, is turned by 2 atan(h w / 2). Beyond what a step can follow it is the speed itself.
double spin_that_turns(double speed, double step) {
  constexpr double most_turn = 2;  // rad
  const double half = 0.5 * step * speed;
  return std::abs(half) < 0.5 * most_turn ? std::tan(half) / (0.5 * step) : speed;
}

}  // namespace

void JointBatch::add_parts(const Joint& joint, const Part& common, double time, double strength) {
  Part part = common;
  part.type = own_type(joint.kind);
  part.law = joint.kind == JointKind::rope ? Law::within : Law::equal;
  part.lower = -std::numeric_limits<double>::infinity(), part.upper = joint.length;
  part.compliance = joint.compliance, part.turning = joint.turning, part.damping = joint.damping;
  parts_.push_back(part);
  part.link = -1;
  const auto add_row = [&](std::size_t first, Law law, double lower, double upper) {
    part.type = coordinate_of(joint.kind), part.first = static_cast<std::uint8_t>(first), part.law = law;
    part.compliance = part.turning = part.damping = 0, part.lower = lower, part.upper = upper;
    parts_.push_back(part);
  };
  if (joint.has_cone()) {
    add_row(JointImpulses::cone, Law::within, -joint.swing, joint.swing);
    parts_.back().type = joint_type_index<Swing>();
  }
  if (joint.is_limited()) add_row(JointImpulses::limits, Law::within, joint.lower, joint.upper);
  const double end = time + step_;
  if (joint.motor == Motor::speed) {
    const bool one_turns = turns_about_axis(joint.kind) && (common.side[0].inverse_mass == 0 || common.side[1].inverse_mass == 0);
    const double speed = joint.target.mean(time, end);
    add_row(JointImpulses::motor, Law::rate, one_turns ? spin_that_turns(speed, step_) : speed, strength);
    parts_.back().presses = joint.area != nullptr;
  }
  if (joint.motor == Motor::position) {
    const double from = joint.target.at(time), to = joint.target.at(end);
    add_row(JointImpulses::motor, Law::place, to, strength);
    limit_approach(parts_.back(), joint.kind, from, (to - from) / step_);
  }
  if (joint.friction > 0) add_row(JointImpulses::friction, Law::rate, 0, joint.friction);
  if (joint.is_sprung()) add_spring(joint, part);
}

// A damper alone is a drive at no speed whose multiplier gives way: over the step it acts as a spring of stiffness damping / h.
void JointBatch::add_spring(const Joint& joint, const Part& common) {
  Part part = common;
  const bool is_stiff = joint.stiffness > 0;
  part.type = coordinate_of(joint.kind), part.first = JointImpulses::spring, part.law = is_stiff ? Law::equal : Law::rate;
  part.compliance = part.turning = is_stiff ? 1 / joint.stiffness : step_ / joint.viscosity;
  part.damping = is_stiff ? joint.viscosity / joint.stiffness : 0;
  part.lower = 0, part.upper = is_stiff ? joint.rest : std::numeric_limits<double>::infinity();
  parts_.push_back(part);
}

// A motor comes to its place no faster than half of its strength can brake by then, so that it stops there: by what the two
// bodies weigh against it in their joint, without what else hangs on them. The place is at `from` at the start of the step and
// moves at `rate`, which comes on top.
void JointBatch::limit_approach(Part& part, JointKind kind, double from, double rate) const {
  const Side &a = part.side[0], &b = part.side[1];
  const SolverBody still{};
  const JointEnd end_a = end_of(a, still, step_), end_b = end_of(b, still, step_);
  const auto row = [&](const auto& rows, std::size_t k) {
    return Row{rows.linear[k], rows.angular[k], other_angular(rows.linear[k], rows.angular[k], end_a, end_b), rows.value[k]};
  };
  const auto product = [&](const Row& r, const Row& s) {
    return (a.inverse_mass + b.inverse_mass) * r.linear.dot(s.linear) + r.angular.dot(a.inverse_inertia * s.angular) +
           r.angular_b.dot(b.inverse_inertia * s.angular_b);
  };
  Row driven;
  double away = 0;
  with_joint_type(part.type, [&]<class T>() {
    JointRows<T::rows> coordinate;
    T::evaluate(end_a, end_b, coordinate);
    driven = row(coordinate, 0), away = coordinate.value[0] - from;
    if (T::angles > 0) away = wrapped(away);
  });
  double mobility = product(driven, driven);
  with_joint_type(own_type(kind), [&]<class J>() {
    JointRows<J::rows> rows;
    J::evaluate(end_a, end_b, rows);
    std::array<std::array<double, J::rows>, J::rows> P;
    std::array<double, J::rows> across;
    for (std::size_t i = 0; i < J::rows; ++i) {
      const Row own = row(rows, i);
      for (std::size_t k = 0; k <= i; ++k) P[i][k] = product(own, row(rows, k));
      if (!(P[i][i] > least_diagonal(a, b, 1, 1, own.linear, own.angular, own.angular_b))) P[i][i] = 0;
      across[i] = product(row(rows, i), driven);
    }
    const auto held = solve_semidefinite<J::rows>(P, across);
    for (std::size_t i = 0; i < J::rows; ++i) mobility -= across[i] * held[i];
  });
  const double speed = std::sqrt(part.upper * std::max(0.0, mobility) * std::abs(away));
  if (std::abs(away) > step_ * speed) part.law = Law::rate, part.lower = rate + (away > 0 ? -speed : speed);
}

void JointBatch::build(const BuildContext& context) {
  any_ = context.elements.joints != nullptr;
  if (!any_) return;
  const std::span<const Joint> joints = context.elements.joints->joints;
  const JointList& list = *context.elements.joints->list;
  const std::vector<JointSlots>& slots = *context.elements.joints->slots;
  const std::int32_t colours = context.elements.joints->colours;
  const World& world = context.world;
  const bool by_colour = context.by_colour;
  step_ = context.state.step, stabilisation_ = context.state.stabilisation, any_tree_ = context.elements.joints->any_tree;
  parts_.clear(), colour_end_.clear(), trees_.clear();
  std::vector<std::uint32_t> order(list.size());
  std::iota(order.begin(), order.end(), 0);
  const auto joint_at = [&](std::uint32_t i) -> const Joint& { return joints[static_cast<std::size_t>(list[i])]; };
  if (by_colour)
    std::stable_sort(order.begin(), order.end(), [&](auto i, auto j) { return joint_at(i).colour < joint_at(j).colour; });
  std::size_t next = 0;
  for (std::int32_t colour = 0; colour < (by_colour ? colours : 1); ++colour) {
    for (; next < order.size() && (!by_colour || joint_at(order[next]).colour == colour); ++next) {
      if (context.elements.joints->is_broken(list[order[next]])) continue;
      const Joint& joint = joint_at(order[next]);
      const JointSlots& ends = slots[order[next]];
      Part part{};
      part.side[0] = joint_side(context, joint, 0, ends.a), part.side[1] = joint_side(context, joint, 1, ends.b);
      part.joint = order[next], part.counted = ends.counted, part.lever = joint.lever;
      part.link = -1;
      const std::size_t own = parts_.size();
      add_parts(joint, part, context.time,
                context.elements.joints->strength_of(list[order[next]], context.time, context.time + step_));
      if (joint.tree >= 0) add_to_tree(parts_[own], joint.tree);
      const auto is_home = [&](Slot s) { return static_cast<std::size_t>(s) < world.homes; };
      if (!is_home(ends.a) && !is_home(ends.b))  // here for its tree alone
        parts_.erase(parts_.begin() + static_cast<std::ptrdiff_t>(own) + 1, parts_.end());
    }
    colour_end_.push_back(parts_.size());
  }
  prepare_rows();
  trees_.factor();
  residual_.assign(trees_.size(), JointTrees::Vector6::Zero()), change_ = residual_;
}

}  // namespace unibody
