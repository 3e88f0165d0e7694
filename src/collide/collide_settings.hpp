// What collision detection needs to know besides the bodies.
#pragma once

#include <algorithm>

#include "collide/struck_bodies.hpp"
#include "core/types.hpp"
#include "world/touch_rules.hpp"

namespace unibody {

struct CollideSettings {
  double step = 0.016;          // s, the time ahead for which contacts are made
  double margin = 0.002;        // m, eps of the margin rule
  Vec3 gravity = Vec3::Zero();  // m/s^2
  bool planar = false;
  bool merge_supports = false;         // of bodies of many parts (merge_supports.hpp)
  bool has_past = false;               // positions are those that the present velocities have led to
  std::vector<double> friction{0.5};   // n x n by material
  std::vector<double> restitution;     // the same; empty: 0 for all
  std::vector<double> stiction;        // the same
  std::vector<double> stiction_speed;  // m/s, the same; not empty where stiction is not
  std::size_t material_count = 1;
  double restitution_of(std::int32_t material_a, std::int32_t material_b) const {
    const auto a = static_cast<std::size_t>(material_a), b = static_cast<std::size_t>(material_b);
    return restitution.empty() ? 0 : restitution[a * material_count + b];
  }
  double largest_restitution_of(std::int32_t material) const {
    if (restitution.empty()) return 0;
    const auto row = restitution.begin() + static_cast<std::ptrdiff_t>(material) * static_cast<std::ptrdiff_t>(material_count);
    return *std::max_element(row, row + static_cast<std::ptrdiff_t>(material_count));
  }
  const TouchRules* touch_rules = nullptr;  // null: all may touch all
  bool may_touch(Id a, Id b) const { return touch_rules == nullptr || touch_rules->may_touch(a, b); }
  StruckBodies struck{};  // that the step has found; empty in most
};

}  // namespace unibody
