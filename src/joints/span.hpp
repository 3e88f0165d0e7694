// The distance between two anchors: a rope where it has an upper bound alone, a spring where it has one length.
#pragma once

#include "joints/joint_type.hpp"

namespace unibody {

struct Span {
  static constexpr std::string_view name = "span";
  static constexpr std::size_t rows = 1, angles = 0;

  // c = |p_a - p_b|; of anchors at one place the direction is the second body's axis z.
  static void evaluate(const JointEnd& a, const JointEnd& b, JointRows<1>& to) {
    const Vec3 between = a.point - b.point;
    const double length = between.norm();
    const Vec3 n = length > 0 ? Vec3(between / length) : Vec3(b.axes.col(2));
    to.value[0] = length, to.linear[0] = n, to.angular[0] = (a.point - a.centre).cross(n);
  }
};

}  // namespace unibody
