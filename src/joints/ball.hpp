// A ball in a socket: two anchors at one place.
#pragma once

#include "joints/joint_type.hpp"

namespace unibody {

struct Ball {
  static constexpr std::string_view name = "ball";
  static constexpr std::size_t rows = 3, angles = 0;

  // c = the first anchor's place against the second, in the second body's axes.
  static void evaluate(const JointEnd& a, const JointEnd& b, JointRows<3>& to) {
    for (int k = 0; k < 3; ++k) joint_rows::set_offset(to, static_cast<std::size_t>(k), k, a, b);
  }
};

}  // namespace unibody
