// One body's side of a joint in a step: where it starts, what it weighs, and where velocities lead it.
#pragma once

#include "constraints/batch.hpp"
#include "joints/joint.hpp"
#include "joints/joint_type.hpp"
#include "world/world.hpp"

namespace unibody {

struct JointSide {
  Slot slot;
  double inverse_mass, share;  // 1/kg; how many constraints share the mass
  Vec3 centre, arm;            // m, at the start of the step; the arm in the joint's axes
  Quat axes;
  Mat3 inverse_inertia;  // 1/(kg m^2), world frame
};

inline Vec3 velocity_of(const SolverBody& body) { return {body.v[0], body.v[1], body.v[2]}; }  // m/s
inline Vec3 spin_of(const SolverBody& body) { return {body.w[0], body.w[1], body.w[2]}; }      // rad/s
inline void add(Vec4d& to, const Vec3& x) { to += Vec4d{x.x(), x.y(), x.z(), 0}; }

// slot: where its body is; of the world one behind all bodies.
inline JointSide joint_side(const BuildContext& context, const Joint& joint, std::size_t end, Slot slot) {
  const SolveState& state = context.state;
  const auto s = static_cast<std::size_t>(slot);
  const double share = state.counts.empty() ? 1 : std::max(1.0, context.settings.scaling * state.counts[s]);
  JointSide side{slot, state.bodies[s].inverse_mass, share, Vec3::Zero(), {}, {}, {}};
  Quat attitude = Quat::Identity();
  if (s < context.world.size()) side.centre = context.world.position[s], attitude = context.world.orientation_of(s);
  side.axes = attitude * joint.frame[end], side.arm = joint.frame[end].conjugate() * joint.anchor[end];
  side.inverse_inertia = inverse_inertia_of(state.bodies, state.inertia, state.isotropic, s);
  return side;
}

// After a step (s) at the body's velocities: the same turn as finish_motion() makes, but where it holds the energy. A step of 0:
// at its start.
inline JointEnd end_of(const JointSide& side, const SolverBody& body, double step) {
  const Vec3 half = 0.5 * step * spin_of(body);
  const Mat3 axes = (Quat(1, half.x(), half.y(), half.z()) * side.axes).normalized().toRotationMatrix();
  const Vec3 centre = side.centre + step * velocity_of(body);
  return {centre, axes, centre + axes * side.arm};
}

}  // namespace unibody
