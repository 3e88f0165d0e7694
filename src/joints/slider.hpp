// A slider: the first anchor moves along the second body's axis, and neither body turns against the other.
#pragma once

#include "joints/joint_type.hpp"

namespace unibody {

struct Slider {
  static constexpr std::string_view name = "slider";
  static constexpr std::size_t rows = 5, angles = 3;

  // The anchors' distance across the axis, and the turn.
  static void evaluate(const JointEnd& a, const JointEnd& b, JointRows<5>& to) {
    for (int k = 0; k < 2; ++k) joint_rows::set_offset(to, static_cast<std::size_t>(k), k, a, b);
    joint_rows::set_turn(to, 2, a, b);
  }
};

}  // namespace unibody
