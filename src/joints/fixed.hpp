// Two bodies as one.
#pragma once

#include "joints/joint_type.hpp"

namespace unibody {

struct Fixed {
  static constexpr std::string_view name = "fixed";
  static constexpr std::size_t rows = 6, angles = 3;

  // A ball's rows, and the turn.
  static void evaluate(const JointEnd& a, const JointEnd& b, JointRows<6>& to) {
    for (int k = 0; k < 3; ++k) joint_rows::set_offset(to, static_cast<std::size_t>(k), k, a, b);
    joint_rows::set_turn(to, 3, a, b);
  }
};

}  // namespace unibody
