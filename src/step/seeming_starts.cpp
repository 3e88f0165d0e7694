#include "step/seeming_starts.hpp"

#include <algorithm>

#include "solve/free_motion.hpp"

namespace unibody {

namespace {

Eigen::Map<Vec3> velocity_of(SolverBody& body) { return Eigen::Map<Vec3>(body.v); }
Eigen::Map<Vec3> spin_of(SolverBody& body) { return Eigen::Map<Vec3>(body.w); }

Vec3 vector_of(const Quat& rotation) {
  const Eigen::AngleAxisd turn(rotation);
  return turn.angle() * turn.axis();
}

}  // namespace

SeemingStarts::SeemingStarts(RankState& state, System& system)
    : state_(state), world_(state.world), system_(system), step_(state.step()) {
  const std::size_t n = world_.size() + 1;
  for (auto* changes : {&state_.impacts.displaced, &state_.impacts.turned, &state_.impacts.attitude})
    changes->assign(n, Vec3::Zero());
  start_velocity_.resize(n), torque_gain_.assign(n, Vec3::Zero());
  any_uneven_ = state_.any_over_ranks(!system_.inertia.empty());
  if (any_uneven_) momentum_.assign(n, Vec3::Zero());
  for (std::size_t i = 0; i < world_.size(); ++i) {
    start_velocity_[i] = velocity(static_cast<Slot>(i));
    if (world_.is_static(static_cast<Slot>(i)) || !world_.properties[i].is_dynamic()) continue;
    const Vec3 now = world_.angular_velocity_of(i);
    torque_gain_[i] = spin_of(system_.bodies[i]) - now;
    if (system_.isotropic[i]) continue;
    torque_gain_[i] += inverse_inertia_of(system_.bodies, system_.inertia, system_.isotropic, i) * system_.gyroscopic[i];
    const Mat3 R = world_.orientation_of(i).toRotationMatrix();
    momentum_[i] = R * world_.properties[i].inertia.cwiseProduct(R.transpose() * now);
  }
}

Vec3 SeemingStarts::acceleration(Slot s) const {
  const auto i = static_cast<std::size_t>(s);
  return world_.is_static(s) ? Vec3(Vec3::Zero()) : Vec3((start_velocity_[i] - world_.velocity[i]) / step_);
}

Vec3 SeemingStarts::place(Slot s, double t) const {
  const auto i = static_cast<std::size_t>(s);
  return world_.position[i] + state_.impacts.displaced[i] + t * velocity(s) + 0.5 * t * (t - step_) * acceleration(s);
}

Quat SeemingStarts::seeming_attitude(std::size_t i) const {
  return turn_by(state_.impacts.attitude[i]) * world_.orientation_of(i);
}

Quat SeemingStarts::attitude(std::size_t i, double t) const {
  if (!moves(static_cast<Slot>(i))) return driven_turn(world_.angular_velocity_of(i), t) * world_.orientation_of(i);
  if (system_.isotropic[i]) return turned_by(seeming_attitude(i), spin(static_cast<Slot>(i), t), t);
  return turned_freely(seeming_attitude(i), momentum_[i], world_.properties[i].inertia, t);
}

Mat3 SeemingStarts::turn(Slot s, double t) const {
  const auto i = static_cast<std::size_t>(s);
  if (is_round_body(s) || world_.properties[i].motion == Motion::fixed) return Mat3::Identity();
  if (t == 0 && state_.impacts.attitude[i].isZero(0)) return Mat3::Identity();
  return (attitude(i, t) * world_.orientation_of(i).conjugate()).toRotationMatrix();
}

Vec3 SeemingStarts::spin(Slot s, double t) const {
  const auto i = static_cast<std::size_t>(s);
  if (!moves(s)) return world_.angular_velocity_of(i);
  if (system_.isotropic[i]) return Eigen::Map<const Vec3>(system_.bodies[i].w) - torque_gain_[i];
  return inverse_inertia(s, t) * momentum_[i];
}

Mat3 SeemingStarts::inverse_inertia(Slot s, double t) const {
  const auto i = static_cast<std::size_t>(s);
  if (!moves(s)) return Mat3::Zero();
  if (system_.isotropic[i] || state_.scene.planar)
    return inverse_inertia_of(system_.bodies, system_.inertia, system_.isotropic, i);
  const Mat3 R = attitude(i, t).toRotationMatrix();
  return R * world_.properties[i].inertia.cwiseInverse().asDiagonal() * R.transpose();
}

void SeemingStarts::push(Slot s, const Vec3& impulse, const Vec3& angular, double time) {
  const auto i = static_cast<std::size_t>(s);
  SolverBody& body = system_.bodies[i];
  if (!(body.inverse_mass > 0)) return;
  const Vec3 change = body.inverse_mass * impulse;
  velocity_of(body) += change;
  state_.impacts.displaced[i] -= time * change;
  const Vec3 turning = inverse_inertia(s, time) * angular;
  state_.impacts.turned[i] -= time * turning;
  if (is_round_body(s) && system_.isotropic[i]) {
    spin_of(body) += turning;
    state_.impacts.attitude[i] = state_.impacts.turned[i];
    return;
  }
  const Quat now = attitude(i, time);
  Quat start;
  if (system_.isotropic[i]) {
    spin_of(body) += turning;
    start = turned_by(now, spin(s, time), -time);
  } else {
    momentum_[i] += angular;
    start = turned_freely(now, momentum_[i], world_.properties[i].inertia, -time);
  }
  state_.impacts.attitude[i] = vector_of(start * world_.orientation_of(i).conjugate());
  settle(i);
}

// What the solve knows of a body's turning, from its momentum and the attitude in which it seems to start.
void SeemingStarts::settle(std::size_t i) {
  if (system_.isotropic[i]) return;
  const Vec3& moments = world_.properties[i].inertia;
  const Quat start = seeming_attitude(i);
  if (!state_.scene.planar) system_.inertia[i] = unibody::inverse_inertia(start, moments.cwiseInverse());
  const FreeTurning turning = free_turning(moments, start, inverse_inertia(static_cast<Slot>(i), 0) * momentum_[i], step_);
  system_.gyroscopic[i] = turning.gyroscopic;
  spin_of(system_.bodies[i]) = turning.mean + torque_gain_[i];
}

void SeemingStarts::tell_guests(std::vector<Slot>& changed) {
  const std::size_t first = world_.homes, end = world_.first_static();
  std::vector<SolverBody> before(system_.bodies.begin() + static_cast<std::ptrdiff_t>(first),
                                 system_.bodies.begin() + static_cast<std::ptrdiff_t>(end));
  state_.exchange.refresh(std::span<SolverBody>(system_.bodies));
  for (auto* changes : {&state_.impacts.displaced, &state_.impacts.turned, &state_.impacts.attitude})
    state_.exchange.refresh(std::span(*changes));
  if (any_uneven_) state_.exchange.refresh(std::span(momentum_));
  for (std::size_t i = first; i < end; ++i) {
    const SolverBody &was = before[i - first], &is = system_.bodies[i];
    if (std::equal(was.v, was.v + 3, is.v) && std::equal(was.w, was.w + 3, is.w)) continue;
    settle(i), changed.push_back(static_cast<Slot>(i));
  }
}

}  // namespace unibody
