// How far a ball joint's first body is turned about its axis z, beside the swing of that axis, in (-pi, pi].
#pragma once

#include <cmath>

#include "joints/joint_type.hpp"

namespace unibody {

struct Twist {
  static constexpr std::string_view name = "twist";
  static constexpr std::size_t rows = 1, angles = 1;

  // The turn of the first copy of the axes against the second, q = (w, v), is a turn about z by t = 2 atan2(v_z, w) and a swing
  // about an axis square to z after it. dt by the turn p in the second copy's axes: ((w v_y + v_z v_x) p_x + (v_z v_y - w v_x)
  // p_y) / (w^2 + v_z^2) + p_z. Where the axes are opposite there is no twist.
  static void evaluate(const JointEnd& a, const JointEnd& b, JointRows<1>& to) {
    const Quat q(Mat3(b.axes.transpose() * a.axes));
    const double w = q.w(), z = q.z(), squared = w * w + z * z;
    to.value[0] = wrapped(2 * std::atan2(z, w)), to.linear[0].setZero(), to.angular[0].setZero();
    if (squared > 1e-12) to.angular[0] = b.axes * Vec3((w * q.y() + z * q.x()) / squared, (z * q.y() - w * q.x()) / squared, 1);
  }
};

}  // namespace unibody
