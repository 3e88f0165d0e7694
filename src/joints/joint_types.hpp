// The list of all types of joints' rows.
#pragma once

#include <tuple>
#include <utility>

#include "joints/angle.hpp"
#include "joints/ball.hpp"
#include "joints/fixed.hpp"
#include "joints/hinge.hpp"
#include "joints/joint.hpp"
#include "joints/offset.hpp"
#include "joints/slider.hpp"
#include "joints/span.hpp"
#include "joints/swing.hpp"
#include "joints/twist.hpp"
#include "joints/universal.hpp"

namespace unibody {

// The types of joints in the order of JointKind, a rope's and a spring's being their span; then what drives and limits act on.
using JointTypes = std::tuple<Ball, Hinge, Slider, Fixed, Universal, Span, Angle, Offset, Swing, Twist>;

template <class T, std::size_t k = 0>
constexpr std::uint8_t joint_type_index() {
  if constexpr (std::is_same_v<T, std::tuple_element_t<k, JointTypes>>)
    return k;
  else
    return joint_type_index<T, k + 1>();
}

// Calls f.template operator()<T>() with the type of that place in the list.
template <std::size_t k = 0, class F>
decltype(auto) with_joint_type(std::uint8_t index, F&& f) {
  if constexpr (k + 1 < std::tuple_size_v<JointTypes>) {
    if (index != k) return with_joint_type<k + 1>(index, std::forward<F>(f));
  }
  static_assert(JointType<std::tuple_element_t<k, JointTypes>>);
  return f.template operator()<std::tuple_element_t<k, JointTypes>>();
}

// The type of a joint's own rows.
inline std::uint8_t own_type(JointKind kind) {
  return kind == JointKind::spring ? joint_type_index<Span>() : static_cast<std::uint8_t>(kind);
}

// The row that measures the angle, twist or offset of a hinge, ball or slider.
inline std::uint8_t coordinate_of(JointKind kind) {
  if (kind == JointKind::ball) return joint_type_index<Twist>();
  return kind == JointKind::hinge ? joint_type_index<Angle>() : joint_type_index<Offset>();
}

}  // namespace unibody
