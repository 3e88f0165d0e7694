// What a type of joint is: geometry alone. A new one is a struct like those beside this file and a name in joint_types.hpp; what
// is numerical (scaling, update, momentum, bounds, sums) stands once, in JointBatch.
//
// A type says how many equations c_k = 0 it has (rows), how many of them, the last ones, measure an angle (angles), and evaluates
// values and gradients. A row's gradient is a force along `linear` on the first body and the opposite on the second, both at the
// first body's anchor, and a couple: all rows are the same however the two bodies are moved and turned as one, so that what the
// second body feels follows from what the first does, and momentum and angular momentum are kept also where a joint is open.
#pragma once

#include <array>
#include <cmath>
#include <concepts>
#include <string_view>

#include "core/types.hpp"

namespace unibody {

// An angle (rad) less whole turns, in [-pi, pi].
inline double wrapped(double angle) { return std::abs(angle) <= M_PI ? angle : std::remainder(angle, 2 * M_PI); }

// One body's side of a joint, in the world's axes.
struct JointEnd {
  Vec3 centre;  // m
  Mat3 axes;    // columns: this body's copy of the joint's axes
  Vec3 point;   // m, its anchor
};

template <std::size_t rows>
struct JointRows {
  std::array<double, rows> value;  // m, then rad
  std::array<Vec3, rows> linear;   // gradient by the first body's place (1 or 1/m); by the second's it is the opposite
  std::array<Vec3, rows> angular;  // gradient by the first body's turn, about its centre (m or 1)
};

// The gradient by the second body's turn, about its centre, of a row with these two.
inline Vec3 other_angular(const Vec3& linear, const Vec3& angular, const JointEnd& a, const JointEnd& b) {
  return -(angular + (a.centre - b.centre).cross(linear));
}

template <class T>
concept JointType = requires(const JointEnd& end, JointRows<T::rows>& rows) {
  { T::name } -> std::convertible_to<std::string_view>;
  { T::angles } -> std::convertible_to<std::size_t>;
  {T::evaluate(end, end, rows)};
};

namespace joint_rows {

// Row k: how far the first anchor lies from the second along axis `axis` of the second body's copy.
template <std::size_t rows>
void set_offset(JointRows<rows>& to, std::size_t k, int axis, const JointEnd& a, const JointEnd& b) {
  const Vec3 n = b.axes.col(axis);
  to.value[k] = n.dot(a.point - b.point), to.linear[k] = n, to.angular[k] = (a.point - a.centre).cross(n);
}

// Row k: the cosine between an axis of the first body's copy and one of the second's, square to each other in a closed joint.
template <std::size_t rows>
void set_square(JointRows<rows>& to, std::size_t k, int axis_a, int axis_b, const JointEnd& a, const JointEnd& b) {
  const Vec3 of_a = a.axes.col(axis_a), of_b = b.axes.col(axis_b);
  to.value[k] = of_a.dot(of_b), to.linear[k].setZero(), to.angular[k] = of_a.cross(of_b);
}

// Rows k to k + 2: the turn of the first copy against the second, twice the vector part of its quaternion (w, v): the angle times
// the axis for small ones, and growing up to half a turn. Gradient of row i by the turn: w e_i + v x e_i.
template <std::size_t rows>
void set_turn(JointRows<rows>& to, std::size_t k, const JointEnd& a, const JointEnd& b) {
  Quat turn(Mat3(b.axes.transpose() * a.axes));
  if (turn.w() < 0) turn.coeffs() = -turn.coeffs();
  for (int i = 0; i < 3; ++i) {
    const auto row = k + static_cast<std::size_t>(i);
    const Vec3 e = Vec3::Unit(i);
    to.value[row] = 2 * turn.vec()[i], to.linear[row].setZero();
    to.angular[row] = b.axes * (turn.w() * e + turn.vec().cross(e));
  }
}

}  // namespace joint_rows

}  // namespace unibody
