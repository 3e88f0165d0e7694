// One body's side of a joint in a step: where it starts, what it weighs, and where velocities lead it.
#pragma once

#include <cmath>

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

// The rotation matrix of (1, half) q, made a unit quaternion: by numbers one by one, in less time than by
// products of packets, whose parts wait for each other in memory.
inline Mat3 turned_axes(const Quat& q, const Vec3& half) {
  const double hx = half.x(), hy = half.y(), hz = half.z();
  const double x = (q.x() + hy * q.z()) - (hz * q.y() - hx * q.w()), y = (q.y() + hy * q.w()) + (hz * q.x() - hx * q.z());
  const double z = (q.z() - hy * q.x()) + (hz * q.w() + hx * q.y()), w = (q.w() - hy * q.y()) - (hz * q.z() + hx * q.x());
  const double norm = std::sqrt((x * x + z * z) + (y * y + w * w));
  return Quat(w / norm, x / norm, y / norm, z / norm).toRotationMatrix();
}

// After a step (s) at the body's velocities: the same turn as finish_motion() makes, but where it holds the energy. A step of 0:
// at its start.
inline JointEnd end_of(const JointSide& side, const SolverBody& body, double step) {
  const Vec3 spin = spin_of(body), half = 0.5 * step * spin;
  Mat3 axes;
  if (side.inverse_mass == 0 && step > 0 && !spin.isZero(0)) {
    const Quat turn(Eigen::AngleAxisd(step * spin.norm(), spin.normalized()));
    axes = (turn * side.axes).normalized().toRotationMatrix();
  } else {
    axes = turned_axes(side.axes, half);
  }
  const Vec3 centre = side.centre + step * velocity_of(body);
  return {centre, axes, centre + axes * side.arm};
}

}  // namespace unibody
