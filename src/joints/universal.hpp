// A universal (Cardan) joint: two anchors at one place, the first body's axis square to the second body's second axis.
#pragma once

#include "joints/joint_type.hpp"

namespace unibody {

struct Universal {
  static constexpr std::string_view name = "universal";
  static constexpr std::size_t rows = 4, angles = 1;

  // A ball's rows, and the cosine between the first body's axis z and the second's x.
  static void evaluate(const JointEnd& a, const JointEnd& b, JointRows<4>& to) {
    for (int k = 0; k < 3; ++k) joint_rows::set_offset(to, static_cast<std::size_t>(k), k, a, b);
    joint_rows::set_square(to, 3, 2, 0, a, b);
  }
};

}  // namespace unibody
