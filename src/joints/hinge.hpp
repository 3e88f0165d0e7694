// A hinge: two anchors at one place, two axes along one line (paper, section 3.2).
#pragma once

#include "joints/joint_type.hpp"

namespace unibody {

struct Hinge {
  static constexpr std::string_view name = "hinge";
  static constexpr std::size_t rows = 5, angles = 2;

  // A ball's rows, and the cosines between the first body's axis z and the second's x and y.
  static void evaluate(const JointEnd& a, const JointEnd& b, JointRows<5>& to) {
    for (int k = 0; k < 3; ++k) joint_rows::set_offset(to, static_cast<std::size_t>(k), k, a, b);
    joint_rows::set_square(to, 3, 2, 0, a, b);
    joint_rows::set_square(to, 4, 2, 1, a, b);
  }
};

}  // namespace unibody
