// A hinge's angle, in (-pi, pi]: what its limits bound and its motor drives.
#pragma once

#include <cmath>

#include "joints/joint_type.hpp"

namespace unibody {

struct Angle {
  static constexpr std::string_view name = "angle";
  static constexpr std::size_t rows = 1, angles = 1;

  // The row of the angle of the first body's axis x against the second's, about the second's axis z.
  static void evaluate(const JointEnd& a, const JointEnd& b, JointRows<1>& to) {
    const Vec3 x = a.axes.col(0), along = b.axes.col(0), across = b.axes.col(1);
    const double c = x.dot(along), s = x.dot(across), squared = c * c + s * s;
    to.value[0] = std::atan2(s, c), to.linear[0].setZero();
    to.angular[0] = squared > 0 ? Vec3(x.cross(c * across - s * along) / squared) : Vec3(b.axes.col(2));
  }
};

}  // namespace unibody
