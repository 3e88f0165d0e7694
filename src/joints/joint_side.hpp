// One body's side of a joint in a step: where it starts, what it weighs, and where velocities lead it.
#pragma once

#include "constraints/row_batch.hpp"
#include "joints/joint.hpp"
#include "joints/joint_type.hpp"
#include "world/world.hpp"

namespace unibody {

struct JointSide : RowSide {
  Vec3 centre, arm;  // m, at the start of the step; the arm in the joint's axes
  Quat axes;
};

// slot: where its body is; of the world one behind all bodies.
inline JointSide joint_side(const BuildContext& context, const Joint& joint, std::size_t end, Slot slot) {
  const auto s = static_cast<std::size_t>(slot);
  JointSide side{row_side(context, slot), Vec3::Zero(), {}, {}};
  Quat attitude = Quat::Identity();
  if (s < context.world.size()) side.centre = context.world.position[s], attitude = context.world.orientation_of(s);
  side.axes = attitude * joint.frame[end], side.arm = joint.frame[end].conjugate() * joint.anchor[end];
  return side;
}

// After a step (s) at the body's velocities: the same turn as finish_motion() makes, but where it holds the energy. A step of 0:
// at its start.
inline JointEnd end_of(const JointSide& side, const SolverBody& body, double step) {
  const Vec3 spin = spin_of(body), half = 0.5 * step * spin;
  Quat turn(1, half.x(), half.y(), half.z());
  if (side.inverse_mass == 0 && step > 0 && !spin.isZero(0)) turn = Eigen::AngleAxisd(step * spin.norm(), spin.normalized());
  const Mat3 axes = (turn * side.axes).normalized().toRotationMatrix();
  const Vec3 centre = side.centre + step * velocity_of(body);
  return {centre, axes, centre + axes * side.arm};
}

}  // namespace unibody
