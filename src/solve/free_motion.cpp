#include "solve/free_motion.hpp"

#include <algorithm>
#include <cmath>

namespace unibody {

namespace {

constexpr double most_turn = 1;            // rad in a step, up to which the solver works with the mean spin
constexpr double most_turn_at_once = 0.2;  // rad: one Cayley map is off by a three hundredth of that
constexpr double turn_of_part = 0.05;      // rad, of what is divided
constexpr int most_parts = 256;
constexpr double least_growth = 1e-4;  // of a body's energy of turning, which is not round-off

bool has_isotropic_inertia(const BodyProperties& body, bool planar) {
  if (body.shape.kind == ShapeKind::particle) return true;
  if (planar) return body.shape.kind != ShapeKind::box;  // one axis only: a scalar, unless the arms leave the plane
  return body.inertia.x() == body.inertia.y() && body.inertia.y() == body.inertia.z();
}

// Solves the 3 x 3 system by Cramer's rule, a, b, c its columns; the matrix below is 2 I plus a small change, far from singular.
Vec3 solve_columns(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& right) {
  const Vec3 bc = b.cross(c);
  return Vec3(right.dot(bc), a.dot(right.cross(c)), a.dot(b.cross(right))) / a.dot(bc);
}

// Body-frame spin of the midpoint: l' - l = h lm x wm with lm = (l + l') / 2 = I wm. Newton's method on wm.
Vec3 midpoint_spin(const Vec3& inertia, const Vec3& spin, double step) {
  Vec3 w = spin;
  const Vec3 l = inertia.cwiseProduct(spin);
  for (int k = 0; k < 20; ++k) {
    const Vec3 lm = inertia.cwiseProduct(w);
    const Vec3 f = 2 * (lm - l) - step * lm.cross(w);
    // Columns of the derivative: 2 I e - h (I e x w + lm x e).
    const Vec3 x(2 * inertia.x(), -step * (lm.z() - inertia.x() * w.z()), -step * (inertia.x() * w.y() - lm.y()));
    const Vec3 y(-step * (inertia.y() * w.z() - lm.z()), 2 * inertia.y(), -step * (lm.x() - inertia.y() * w.x()));
    const Vec3 z(-step * (lm.y() - inertia.z() * w.y()), -step * (inertia.z() * w.x() - lm.x()), 2 * inertia.z());
    const Vec3 change = solve_columns(x, y, z, f);
    w -= change;
    if (change.squaredNorm() <= 1e-24 * w.squaredNorm()) break;  // quadratic: the next change would be below round-off
  }
  return w;
}

// Twice the energy of turning (J) with this momentum at this attitude.
double energy_of_turning(const Vec3& momentum, const Mat3& attitude, const Vec3& inertia) {
  const Vec3 own = attitude.transpose() * momentum;
  return own.dot(own.cwiseQuotient(inertia));
}

InverseInertia six_of(const Mat3& W) { return {W(0, 0), W(1, 1), W(2, 2), W(1, 2), W(0, 2), W(0, 1)}; }

}  // namespace

InverseInertia inverse_inertia(const Quat& orientation, const Vec3& inverse_moments) {
  const Mat3 R = orientation.toRotationMatrix();
  return six_of(R * inverse_moments.asDiagonal() * R.transpose());
}

FreeTurning free_turning(const Vec3& moments, const Quat& orientation, const Vec3& spin, double step) {
  if (spin == Vec3::Zero() || step * spin.norm() > most_turn) return {spin, Vec3::Zero()};
  const Mat3 R = orientation.toRotationMatrix();
  const Vec3 own = R.transpose() * spin, mean = midpoint_spin(moments, own, step);
  return {R * mean, R * moments.cwiseProduct(own - mean)};
}

FreeMotion predict_motion(const BodyProperties& body, const BodyState& state, const Vec3& gravity, double step, bool planar) {
  FreeMotion motion{};
  motion.isotropic = true;
  motion.gyroscopic = Vec3::Zero();
  Vec3 v = state.velocity, w = state.angular_velocity;
  if (body.is_dynamic()) {
    motion.body.inverse_mass = 1 / body.mass;
    v += step * (gravity + body.force / body.mass);
    motion.isotropic = has_isotropic_inertia(body, planar);
    if (motion.isotropic) {
      const double inverse = body.shape.kind == ShapeKind::particle ? 0 : 1 / body.inertia.y();
      motion.body.inverse_inertia = inverse;
      w += step * inverse * body.torque;
    } else {
      const Mat3 R = state.orientation.toRotationMatrix();
      const Vec3 inverse = body.inertia.cwiseInverse();
      Mat3 W = R * inverse.asDiagonal() * R.transpose();
      if (planar) W = Vec3(0, inverse.y(), 0).asDiagonal();  // turned about y, it is the same to the last bit
      motion.inverse_inertia = six_of(W);
      if (!planar) {
        const FreeTurning turning = free_turning(body.inertia, state.orientation, w, step);
        motion.gyroscopic = turning.gyroscopic, w = turning.mean;
      }
      w += step * (W * body.torque);
    }
  }
  Eigen::Map<Vec3>(motion.body.v) = v;
  Eigen::Map<Vec3>(motion.body.w) = w;
  return motion;
}

Quat turn_by(const Vec3& rotation) {
  const double angle = rotation.norm();
  return angle > 0 ? Quat(Eigen::AngleAxisd(angle, rotation / angle)) : Quat::Identity();
}

Quat turned_by(const Quat& orientation, const Vec3& spin, double step) {
  const Vec3 half = 0.5 * step * spin;
  return (Quat(1, half.x(), half.y(), half.z()) * orientation).normalized();
}

Quat driven_turn(const Vec3& spin, double step) {
  const double rate = spin.norm();
  return rate > 0 ? Quat(Eigen::AngleAxisd(step * rate, spin / rate)) : Quat::Identity();
}

namespace {

// Into how many parts a turn is divided.
int parts_of(double angle) {
  if (!(angle > most_turn_at_once)) return 1;
  return static_cast<int>(std::min<double>(most_parts, std::ceil(angle / turn_of_part)));
}

Quat turned_freely(Quat orientation, const Vec3& momentum, const Vec3& inertia, double step, int parts) {
  for (int k = 0; k < parts; ++k) {
    const Mat3 R = orientation.toRotationMatrix();
    const Vec3 own = (R.transpose() * momentum).cwiseQuotient(inertia);
    orientation = turned_by(orientation, R * midpoint_spin(inertia, own, step / parts), step / parts);
  }
  return orientation;
}

}  // namespace

Quat turned_freely(const Quat& orientation, const Vec3& momentum, const Vec3& moments, double step) {
  const Vec3 own = orientation.conjugate() * momentum;
  return turned_freely(orientation, momentum, moments, step, parts_of(std::abs(step) * own.cwiseQuotient(moments).norm()));
}

BodyState finish_motion(const BodyProperties& body, const BodyState& state, const SolverBody& moving, const SolverBody& solved,
                        const Vec3& gyroscopic, double step, bool planar, bool free) {
  BodyState next = state;
  next.velocity = Eigen::Map<const Vec3>(solved.v);
  next.angular_velocity = Eigen::Map<const Vec3>(solved.w);
  next.position += step * Eigen::Map<const Vec3>(moving.v);
  if (body.shape.kind == ShapeKind::particle) return next;  // it does not turn
  const Vec3 spin = Eigen::Map<const Vec3>(moving.w);
  const double angle = step * spin.norm();
  const int parts = free ? parts_of(angle) : 1;
  next.orientation = turned_by(state.orientation, spin, step);
  if (angle > 0 && !body.is_dynamic()) next.orientation = (driven_turn(spin, step) * state.orientation).normalized();
  if (parts > 1) next.orientation = Quat(Eigen::AngleAxisd(step * spin.norm(), spin.normalized())) * state.orientation;
  if (!body.is_dynamic() || planar || has_isotropic_inertia(body, planar)) return next;
  // The spin follows from the momentum in the new attitude.
  const Mat3 before = state.orientation.toRotationMatrix();
  const Vec3 momentum = before * body.inertia.cwiseProduct(before.transpose() * next.angular_velocity) + gyroscopic;
  Mat3 after = next.orientation.toRotationMatrix();
  const bool fast = step * std::max(spin.norm(), state.angular_velocity.norm()) > most_turn;
  if (parts > 1) {
    next.orientation = turned_freely(state.orientation, momentum, body.inertia, step, parts);
    after = next.orientation.toRotationMatrix();
  } else if (fast || energy_of_turning(momentum, after, body.inertia) >
                         (1 + least_growth) * energy_of_turning(momentum, before, body.inertia)) {
    const Vec3 own = (before.transpose() * momentum).cwiseQuotient(body.inertia);
    next.orientation = turned_by(state.orientation, before * midpoint_spin(body.inertia, own, step), step);
    after = next.orientation.toRotationMatrix();
  }
  next.angular_velocity = after * (after.transpose() * momentum).cwiseQuotient(body.inertia);
  return next;
}

}  // namespace unibody
