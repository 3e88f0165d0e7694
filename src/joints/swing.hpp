// How far a ball joint's two axes z are turned from each other, in [0, pi]: what a cone bounds.
#pragma once

#include <cmath>

#include "joints/joint_type.hpp"

namespace unibody {

struct Swing {
  static constexpr std::string_view name = "swing";
  static constexpr std::size_t rows = 1, angles = 1;

  // Along one line the axes have no common normal: the gradient is zero there.
  static void evaluate(const JointEnd& a, const JointEnd& b, JointRows<1>& to) {
    const Vec3 of_a = a.axes.col(2), of_b = b.axes.col(2), normal = of_b.cross(of_a);
    const double s = normal.norm();
    to.value[0] = std::atan2(s, of_a.dot(of_b)), to.linear[0].setZero();
    to.angular[0] = s > 1e-12 ? Vec3(normal / s) : Vec3(Vec3::Zero());
  }
};

}  // namespace unibody
