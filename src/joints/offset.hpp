// A slider's way: what its limits bound and its motor drives.
#pragma once

#include "joints/joint_type.hpp"

namespace unibody {

struct Offset {
  static constexpr std::string_view name = "offset";
  static constexpr std::size_t rows = 1, angles = 0;

  // The row of the first anchor's offset from the second, along the second body's axis z.
  static void evaluate(const JointEnd& a, const JointEnd& b, JointRows<1>& to) { joint_rows::set_offset(to, 0, 2, a, b); }
};

}  // namespace unibody
