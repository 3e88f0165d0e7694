#include "step/division.hpp"

#include <algorithm>
#include <cmath>

#include "core/largest.hpp"

namespace unibody {

namespace {

constexpr double turn_of_part = 0.25;  // rad

// The part of a body's angular velocity (rad/s) that would open or tilt its joint within the step. Turning about the joint's own
// axis does neither, so a wheel on its axle counts as not turning.
double turn_that_matters(const RankState& state, const Joint& joint, std::size_t end, Slot slot) {
  if (joint.ids[end] < 0 || slot < 0 || static_cast<std::size_t>(slot) >= state.world.size()) return 0;
  const auto i = static_cast<std::size_t>(slot);
  const Vec3 spin = state.world.angular_velocity_of(i);
  const Quat turn = state.world.orientation_of(i);
  const Vec3 arm = turn * joint.anchor[end];
  const double across_arm = spin.cross(arm).norm();
  double matters = across_arm > 1e-3 * spin.norm() * joint.lever ? spin.norm() : 0;
  const Vec3 axis = turn * (joint.frame[end] * Vec3::UnitZ());
  if (joint.kind == JointKind::fixed || joint.kind == JointKind::slider) matters = spin.norm();
  if (joint.kind == JointKind::hinge || joint.kind == JointKind::universal || joint.has_cone())
    matters = std::max(matters, spin.cross(axis).norm());
  return matters;
}

constexpr int most_fineness = 4;

// So many calm steps halve the parts, with contacts below that share of what is allowed. After so many deep ones it is no
// matter of the steps' length, but of something that presses bodies into each other, or of how they were placed.
constexpr int calm_steps = 10, deep_steps = 25;
constexpr double calm_share = 0.5;

double deepest_contact(const RankState& state) {
  double depth = 0;
  for (const ContactPoint& point : state.contacts.points) depth = std::max(depth, -point.gap);
  for (const SurfaceContact& contact : state.contacts.surface) depth = std::max(depth, -contact.gap);
  return largest_of_ranks(state.comm(), depth);
}

}  // namespace

Fineness next_fineness(Fineness before, double deepest, double allowed) {
  Fineness next = before;
  const bool deep = deepest > allowed, calm = deepest <= calm_share * allowed;
  next.deep = deep ? before.deep + 1 : 0, next.calm = calm ? before.calm + 1 : 0;
  if (next.deep > deep_steps) return next.parts = 1, next;
  if (deep) next.parts = std::min(2 * before.parts, most_fineness);
  if (next.calm >= calm_steps) next.parts = std::max(1, before.parts / 2), next.calm = 0;
  return next;
}

void renew_fineness(RankState& state) {
  if (!state.scene.solver.accuracy || !std::isfinite(state.traits.smallest_size)) return;
  const double allowed = *state.scene.solver.accuracy * state.traits.smallest_size;
  Fineness& fineness = state.history.fineness;
  const int before = fineness.parts;
  fineness = next_fineness(fineness, deepest_contact(state), allowed);
  // The shorter a step, the less of its error is seen in its residual.
  if (fineness.parts != before) state.history.error_ratio.next = std::min(state.history.error_ratio.next, state.when.steps_done);
}

int parts_of_step(const RankState& state) {
  const int least = state.history.fineness.parts;
  if (!state.traits.has_joints || !state.world.has_rotations) return least;
  double fastest = 0;
  for (std::size_t i = 0; i < state.ties.joints.size(); ++i) {
    if (state.ties.joint_input.is_broken(state.ties.joints[i])) continue;
    const Joint& joint = state.scene.joints[static_cast<std::size_t>(state.ties.joints[i])];
    for (const auto& [end, slot] :
         {std::pair(std::size_t{0}, state.ties.joint_slots[i].a), std::pair(std::size_t{1}, state.ties.joint_slots[i].b)})
      fastest = std::max(fastest, turn_that_matters(state, joint, end, slot));
  }
  const double turn = state.step() * largest_of_ranks(state.comm(), fastest);
  const double parts = turn > most_turn_of_rows ? std::ceil(turn / turn_of_part) : 1;
  return static_cast<int>(
      std::clamp(parts, static_cast<double>(least), static_cast<double>(most_parts)));  // what is not finite is found elsewhere
}

void set_step_length(RankState& state, double step) {
  const double ratio = step / state.step();
  state.traits.step = state.search.settings.step = step;
  for_each_batch_type([&]<class B>(auto, std::type_identity<B>) {
    if constexpr (KeyedBatch<B> && !std::is_same_v<B, JointBatch>)
      for (auto& multipliers : state.history.of<B>())
        for (std::size_t k = 0; k < std::min(multipliers.size(), B::remembered_impulses); ++k) multipliers[k] *= ratio;
  });
  for (JointImpulses& joint : state.history.joints())
    for (double& x : joint.value) x *= ratio;
}

}  // namespace unibody
