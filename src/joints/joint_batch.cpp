#include "joints/joint_batch.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "joints/joint_types.hpp"

namespace unibody {

// Values and gradients of a part's rows.
template <class T>
struct JointBatch::Rows : JointRows<T::rows> {
  std::array<Vec3, T::rows> angular_b;
};

// A step of the multipliers: where they come to, and P times what they moved by (m/s or rad/s), the gradient mapping.
template <class T>
struct JointBatch::Step {
  Rows<T> rows;
  std::array<double, T::rows> next, defect;
};

namespace {

constexpr double least_pivot = 1e-10;  // of a row's diagonal
constexpr double most_turn = 0.5;      // rad in a step, up to which rows are taken as curved as they are

Vec3 velocity_of(const SolverBody& b) { return {b.v[0], b.v[1], b.v[2]}; }
Vec3 spin_of(const SolverBody& b) { return {b.w[0], b.w[1], b.w[2]}; }
void add(Vec4d& to, const Vec3& x) { to += Vec4d{x.x(), x.y(), x.z(), 0}; }

// Solves P d = b for symmetric positive semidefinite P (lower triangle) by L D L^T. A row whose pivot is round-off gets d = 0.
template <std::size_t n>
std::array<double, n> solve_semidefinite(std::array<std::array<double, n>, n> P, std::array<double, n> b) {
  std::array<double, n> inverse;
  for (std::size_t j = 0; j < n; ++j) {
    double pivot = P[j][j];
    for (std::size_t k = 0; k < j; ++k) pivot -= P[j][k] * P[j][k] * inverse[k];
    inverse[j] = pivot > least_pivot * P[j][j] ? 1 / pivot : 0;
    for (std::size_t i = j + 1; i < n; ++i)
      for (std::size_t k = 0; k < j; ++k) P[i][j] -= P[i][k] * P[j][k] * inverse[k];
    for (std::size_t k = 0; k < j; ++k) b[j] -= P[j][k] * inverse[k] * b[k];
  }
  for (std::size_t i = n; i-- > 0;) {
    b[i] *= inverse[i];
    for (std::size_t k = i + 1; k < n && inverse[i] > 0; ++k) b[i] -= P[k][i] * inverse[i] * b[k];
  }
  return b;
}

// The multiplier that a step of 1 / P brings a row within limits to: its proximal map.
double within_limits(double lambda, double value, double lower, double upper, double to_impulse) {
  const double up = lambda + (lower - value) * to_impulse, down = lambda + (upper - value) * to_impulse;
  return up > 0 ? up : down < 0 ? down : 0;
}

}  // namespace

void JointBatch::count(std::span<const Joint> joints, const JointList& list, std::span<const JointSlots> slots,
                       std::span<std::int32_t> counts) {
  std::vector<std::uint8_t> in_tree(counts.size(), 0);
  for (std::size_t i = 0; i < list.size(); ++i) {
    const Joint& joint = joints[static_cast<std::size_t>(list[i])];
    const std::int32_t beside = (joint.is_limited() ? 1 : 0) + (joint.has_cone() ? 1 : 0) + (joint.motor != Motor::none ? 1 : 0) +
                                (joint.friction > 0 ? 1 : 0);
    for (const Slot slot : {slots[i].a, slots[i].b}) {
      const auto s = static_cast<std::size_t>(slot);
      counts[s] += beside;
      if (joint.tree < 0 || !in_tree[s]) ++counts[s];
      if (joint.tree >= 0) in_tree[s] = 1;
    }
  }
}

void JointBatch::add_parts(const Joint& joint, const Part& common) {
  Part part = common;
  part.type = static_cast<std::uint8_t>(joint.kind);
  part.law = joint.kind == JointKind::rope ? Law::within : Law::equal;
  part.lower = -std::numeric_limits<double>::infinity(), part.upper = joint.length;
  part.compliance = joint.compliance, part.turning = joint.turning, part.damping = joint.damping;
  parts_.push_back(part);
  part.link = -1;
  const auto add_row = [&](std::size_t first, Law law, double lower, double upper) {
    part.type = coordinate_of(joint.kind), part.first = static_cast<std::uint8_t>(first), part.law = law;
    part.compliance = part.turning = part.damping = 0, part.lower = lower, part.upper = upper;
    parts_.push_back(part);
  };
  if (joint.has_cone()) {
    add_row(JointImpulses::cone, Law::within, -joint.swing, joint.swing);
    parts_.back().type = joint_type_index<Swing>();
  }
  if (joint.is_limited()) add_row(JointImpulses::limits, Law::within, joint.lower, joint.upper);
  if (joint.motor == Motor::speed) add_row(JointImpulses::motor, Law::rate, joint.target, joint.strength);
  if (joint.motor == Motor::position) {
    add_row(JointImpulses::motor, Law::place, joint.target, joint.strength);
    limit_approach(parts_.back(), joint.kind);
  }
  if (joint.friction > 0) add_row(JointImpulses::friction, Law::rate, 0, joint.friction);
}

// A motor comes to its place no faster than half of its strength can brake by then, so that it stops there: by what the two
// bodies weigh against it in their joint, without what else hangs on them.
void JointBatch::limit_approach(Part& part, JointKind kind) const {
  struct Row {
    Vec3 linear, angular, angular_b;
  };
  const Side &a = part.side[0], &b = part.side[1];
  const SolverBody still{};
  const JointEnd end_a = end_of(a, still, step_), end_b = end_of(b, still, step_);
  const auto row = [&](const auto& rows, std::size_t k) {
    return Row{rows.linear[k], rows.angular[k], other_angular(rows.linear[k], rows.angular[k], end_a, end_b)};
  };
  const auto product = [&](const Row& r, const Row& s) {
    return (a.inverse_mass + b.inverse_mass) * r.linear.dot(s.linear) + r.angular.dot(a.inverse_inertia * s.angular) +
           r.angular_b.dot(b.inverse_inertia * s.angular_b);
  };
  with_joint_type(part.type, [&]<class T>() {
    JointRows<T::rows> coordinate;
    T::evaluate(end_a, end_b, coordinate);
    const Row driven = row(coordinate, 0);
    double mobility = product(driven, driven);
    with_joint_type(static_cast<std::uint8_t>(kind), [&]<class J>() {
      JointRows<J::rows> rows;
      J::evaluate(end_a, end_b, rows);
      std::array<std::array<double, J::rows>, J::rows> P;
      std::array<double, J::rows> across;
      for (std::size_t i = 0; i < J::rows; ++i) {
        for (std::size_t k = 0; k <= i; ++k) P[i][k] = product(row(rows, i), row(rows, k));
        across[i] = product(row(rows, i), driven);
      }
      const auto held = solve_semidefinite<J::rows>(P, across);
      for (std::size_t i = 0; i < J::rows; ++i) mobility -= across[i] * held[i];
    });
    double away = coordinate.value[0] - part.lower;
    if (T::angles > 0) away = std::remainder(away, 2 * M_PI);
    const double speed = std::sqrt(part.upper * std::max(0.0, mobility) * std::abs(away));
    if (std::abs(away) > step_ * speed) part.law = Law::rate, part.lower = away > 0 ? -speed : speed;
  });
}

void JointBatch::build(std::span<const Joint> joints, const JointList& list, std::span<const JointSlots> slots, bool by_colour,
                       std::int32_t colours, const World& world, std::span<const SolverBody> bodies,
                       std::span<const InverseInertia> inertia, std::span<const std::uint8_t> isotropic,
                       std::span<const std::int32_t> counts, double scaling, double step, double stabilisation) {
  step_ = step, stabilisation_ = stabilisation;
  parts_.clear(), colour_end_.clear(), trees_.clear();
  std::vector<std::uint32_t> order(list.size());
  std::iota(order.begin(), order.end(), 0);
  const auto joint_at = [&](std::uint32_t i) -> const Joint& { return joints[static_cast<std::size_t>(list[i])]; };
  if (by_colour)
    std::stable_sort(order.begin(), order.end(), [&](auto i, auto j) { return joint_at(i).colour < joint_at(j).colour; });
  const auto side_of = [&](const Joint& joint, std::size_t end, Slot slot) {
    const auto s = static_cast<std::size_t>(slot);
    Side side{slot, bodies[s].inverse_mass, counts.empty() ? 1 : std::max(1.0, scaling * counts[s]), Vec3::Zero(), {}, {}, {}};
    Quat attitude = Quat::Identity();
    if (s < world.size()) side.centre = world.position[s], attitude = world.orientation_of(s);
    side.axes = attitude * joint.frame[end], side.arm = joint.frame[end].conjugate() * joint.anchor[end];
    side.inverse_inertia = inverse_inertia_of(bodies, inertia, isotropic, s);
    return side;
  };
  std::size_t next = 0;
  for (std::int32_t colour = 0; colour < (by_colour ? colours : 1); ++colour) {
    for (; next < order.size() && (!by_colour || joint_at(order[next]).colour == colour); ++next) {
      const Joint& joint = joint_at(order[next]);
      const JointSlots& ends = slots[order[next]];
      Part part{};
      part.side[0] = side_of(joint, 0, ends.a), part.side[1] = side_of(joint, 1, ends.b);
      part.joint = order[next], part.counted = ends.counted, part.lever = joint.lever;
      part.link = -1;
      const std::size_t own = parts_.size();
      add_parts(joint, part);
      if (joint.tree >= 0) add_to_tree(parts_[own], joint.tree, bodies);
      const auto is_home = [&](Slot s) { return static_cast<std::size_t>(s) < world.homes; };
      if (!is_home(ends.a) && !is_home(ends.b))  // here for its tree alone
        parts_.erase(parts_.begin() + static_cast<std::ptrdiff_t>(own) + 1, parts_.end());
    }
    colour_end_.push_back(parts_.size());
  }
  trees_.factor();
  residual_.assign(trees_.size(), JointTrees::Vector6::Zero()), change_ = residual_;
}

namespace {

// S of W = S S^T, W symmetric and positive semidefinite.
Mat3 square_root_of(const Mat3& W) {
  Mat3 S = Mat3::Zero();
  for (int j = 0; j < 3; ++j) {
    const double pivot = W(j, j) - S.row(j).head(j).squaredNorm();
    if (!(pivot > least_pivot * W(j, j))) continue;
    S(j, j) = std::sqrt(pivot);
    for (int i = j + 1; i < 3; ++i) S(i, j) = (W(i, j) - S.row(i).head(j).dot(S.row(j).head(j))) / S(j, j);
  }
  return S;
}

}  // namespace

void JointBatch::add_to_tree(Part& part, std::int32_t tree, std::span<const SolverBody> bodies) {
  with_joint_type(part.type, [&]<class T>() {
    const Rows<T> at = evaluate<T>(part, bodies);
    JointTrees::Vector6 compliance = JointTrees::Vector6::Zero();
    std::array<JointTrees::Side, 2> sides;
    for (std::size_t e = 0; e < 2; ++e) {
      const Side& side = part.side[e];
      sides[e] = {side.slot, side.inverse_mass > 0, JointTrees::Matrix6::Zero()};
      const Mat3 turn = square_root_of(side.share * side.inverse_inertia);
      const double move = std::sqrt(side.share * side.inverse_mass) * (e == 0 ? 1 : -1);
      for (std::size_t k = 0; k < T::rows; ++k) {
        const auto row = static_cast<Eigen::Index>(k);
        sides[e].rows.row(row).head<3>() = move * at.linear[k].transpose();
        sides[e].rows.row(row).tail<3>() = (e == 0 ? at.angular[k] : at.angular_b[k]).transpose() * turn;
        compliance[row] = (k + T::angles < T::rows ? part.compliance : part.turning) / (step_ * (step_ + part.damping));
      }
    }
    part.link = static_cast<std::int32_t>(trees_.add(tree, sides[0], sides[1], compliance));
  });
}

// Leaves in change_ what the multipliers of the trees' joints are to change by.
void JointBatch::solve_trees(std::span<const SolverBody> bodies, bool extrapolated) {
  if (trees_.size() == 0) return;
  for (const Part& part : parts_)
    if (part.link >= 0)
      with_joint_type(part.type, [&]<class T>() {
        const auto r = residual_of<T>(part, evaluate_ahead<T>(part, bodies), extrapolated ? part.y : part.lambda, bodies);
        for (std::size_t k = 0; k < T::rows; ++k)
          residual_[static_cast<std::size_t>(part.link)][static_cast<Eigen::Index>(k)] = r[k];
      });
  trees_.solve(residual_, change_);
}

// After solve_trees.
template <class T>
JointBatch::Step<T> JointBatch::step_in_tree(const Part& part, const std::array<double, 6>& from,
                                             std::span<const SolverBody> bodies) const {
  const auto link = static_cast<std::size_t>(part.link);
  Step<T> step{evaluate<T>(part, bodies), {}, {}};
  for (std::size_t k = 0; k < T::rows; ++k) {
    const auto row = static_cast<Eigen::Index>(k);
    step.next[k] = from[k] + change_[link][row], step.defect[k] = residual_[link][row];
  }
  return step;
}

void JointBatch::set_impulses(std::span<const JointImpulses> impulses, double share) {
  for (Part& part : parts_) {
    part.lambda.fill(0);
    if (share > 0 && part.link < 0)
      with_joint_type(part.type, [&]<class T>() {
        for (std::size_t k = 0; k < T::rows; ++k) part.lambda[k] = share * impulses[part.joint].value[part.first + k];
      });
    part.y = part.lambda;
  }
}

void JointBatch::get_impulses(std::span<JointImpulses> impulses) const {
  for (const Part& part : parts_)
    with_joint_type(part.type, [&]<class T>() {
      std::copy_n(part.lambda.begin(), T::rows, impulses[part.joint].value.begin() + part.first);
    });
}

// After the step at these velocities: the same turn as finish_motion() makes.
JointEnd JointBatch::end_of(const Side& side, const SolverBody& body, double step) {
  const Vec3 half = 0.5 * step * spin_of(body);
  const Mat3 axes = (Quat(1, half.x(), half.y(), half.z()) * side.axes).normalized().toRotationMatrix();
  const Vec3 centre = side.centre + step * velocity_of(body);
  return {centre, axes, centre + axes * side.arm};
}

// At the start of the step.
template <class T>
JointBatch::Rows<T> JointBatch::evaluate(const Part& part, std::span<const SolverBody> bodies) {
  const JointEnd a = end_of(part.side[0], bodies[static_cast<std::size_t>(part.side[0].slot)], 0);
  const JointEnd b = end_of(part.side[1], bodies[static_cast<std::size_t>(part.side[1].slot)], 0);
  Rows<T> rows;
  T::evaluate(a, b, rows);
  for (std::size_t k = 0; k < T::rows; ++k) rows.angular_b[k] = other_angular(rows.linear[k], rows.angular[k], a, b);
  return rows;
}

// The same with the values after the step; less of their curve the farther a body turns, and none at velocity level.
template <class T>
JointBatch::Rows<T> JointBatch::evaluate_ahead(const Part& part, std::span<const SolverBody> bodies) const {
  Rows<T> rows = evaluate<T>(part, bodies);
  const SolverBody &of_a = bodies[static_cast<std::size_t>(part.side[0].slot)],
                   &of_b = bodies[static_cast<std::size_t>(part.side[1].slot)];
  const Vec3 along = velocity_of(of_a) - velocity_of(of_b), spin_a = spin_of(of_a), spin_b = spin_of(of_b);
  const double turn = step_ * step_ * std::max(spin_a.squaredNorm(), spin_b.squaredNorm());
  const double part_of_curve = std::min(1.0, most_turn * most_turn / turn);
  Rows<T> ahead;
  if (stabilisation_ < 0) T::evaluate(end_of(part.side[0], of_a, step_), end_of(part.side[1], of_b, step_), ahead);
  for (std::size_t k = 0; k < T::rows; ++k) {
    const double straight =
        rows.value[k] + step_ * (rows.linear[k].dot(along) + rows.angular[k].dot(spin_a) + rows.angular_b[k].dot(spin_b));
    if (stabilisation_ >= 0) {
      rows.value[k] = straight - left_alone<T>(part, k, rows.value[k]);
      continue;
    }
    double curve = ahead.value[k] - straight;
    if (T::rows == 1 && T::angles == 1) curve = std::remainder(curve, 2 * M_PI);
    rows.value[k] = straight + part_of_curve * curve;
  }
  return rows;
}

// What the velocity level leaves for later steps of a row's error at the start of this one.
template <class T>
double JointBatch::left_alone(const Part& part, std::size_t row, double value) const {
  const double compliance = row + T::angles < T::rows ? part.compliance : part.turning;
  if (part.law == Law::equal) return compliance > 0 || part.damping > 0 ? 0 : (1 - stabilisation_) * value;
  if (part.law != Law::within) return 0;
  return (1 - stabilisation_) * (value > part.upper ? value - part.upper : std::min(0.0, value - part.lower));
}

// r of a joint's own rows, or what a drive misses (m/s or rad/s).
template <class T>
std::array<double, T::rows> JointBatch::residual_of(const Part& part, const Rows<T>& at, const std::array<double, 6>& lambda,
                                                    std::span<const SolverBody> bodies) const {
  const SolverBody &a = bodies[static_cast<std::size_t>(part.side[0].slot)],
                   &b = bodies[static_cast<std::size_t>(part.side[1].slot)];
  const Vec3 along = velocity_of(a) - velocity_of(b), spin_a = spin_of(a), spin_b = spin_of(b);
  std::array<double, T::rows> r;
  for (std::size_t k = 0; k < T::rows; ++k) {
    const double rate = at.linear[k].dot(along) + at.angular[k].dot(spin_a) + at.angular_b[k].dot(spin_b);
    const double compliance = k + T::angles < T::rows ? part.compliance : part.turning;
    if (part.law == Law::equal)
      r[k] = (at.value[k] + compliance * lambda[k] / step_ + part.damping * rate) / (step_ + part.damping);
    else if (part.law == Law::rate)
      r[k] = rate - part.lower;
    else if (T::angles > 0)
      r[k] = std::remainder(at.value[k] - part.lower, 2 * M_PI) / step_;
    else
      r[k] = (at.value[k] - part.lower) / step_;
  }
  return r;
}

template <class T>
JointBatch::Step<T> JointBatch::step_from(const Part& part, const std::array<double, 6>& from, std::span<const SolverBody> bodies,
                                          bool shared) const {
  constexpr std::size_t n = T::rows;
  Step<T> step{evaluate_ahead<T>(part, bodies), {}, {}};
  const Rows<T>& at = step.rows;
  const Side &a = part.side[0], &b = part.side[1];
  const double share_a = shared ? a.share : 1, share_b = shared ? b.share : 1;
  const double mobility = share_a * a.inverse_mass + share_b * b.inverse_mass;
  std::array<std::array<double, n>, n> P;
  for (std::size_t i = 0; i < n; ++i) {
    const Vec3 turn_a = share_a * (a.inverse_inertia * at.angular[i]), turn_b = share_b * (b.inverse_inertia * at.angular_b[i]);
    for (std::size_t j = 0; j <= i; ++j)
      P[i][j] = mobility * at.linear[i].dot(at.linear[j]) + turn_a.dot(at.angular[j]) + turn_b.dot(at.angular_b[j]);
    const double compliance = i + T::angles < n ? part.compliance : part.turning;
    P[i][i] += compliance / (step_ * (step_ + part.damping));
  }
  if (part.law == Law::equal) {
    step.defect = residual_of<T>(part, at, from, bodies);
    const auto change = solve_semidefinite<n>(P, step.defect);
    for (std::size_t k = 0; k < n; ++k) step.next[k] = from[k] - change[k];
  } else {
    step.next[0] = from[0], step.defect[0] = 0;
    if (!(P[0][0] > 0)) return step;
    if (part.law == Law::within) {
      step.next[0] = within_limits(from[0], at.value[0], part.lower, part.upper, 1 / (step_ * P[0][0]));
    } else {
      const double most = step_ * part.upper;
      step.next[0] = std::clamp(from[0] - residual_of<T>(part, at, from, bodies)[0] / P[0][0], -most, most);
    }
    step.defect[0] = P[0][0] * (from[0] - step.next[0]);
  }
  return step;
}

// Of a value of a row, a length (m).
template <class T>
double JointBatch::length_of(const Part& part, std::size_t row, double x) {
  return std::abs(x) * (row + T::angles < T::rows ? 1 : part.lever);
}

namespace {

// D lambda: on the first body, whose opposite is the second's, and the two torques.
template <class Rows, std::size_t n>
std::array<Vec3, 3> wrench_of(const Rows& at, const std::array<double, n>& lambda) {
  std::array<Vec3, 3> sum{Vec3::Zero(), Vec3::Zero(), Vec3::Zero()};
  for (std::size_t k = 0; k < at.value.size(); ++k)
    sum[0] += lambda[k] * at.linear[k], sum[1] += lambda[k] * at.angular[k], sum[2] += lambda[k] * at.angular_b[k];
  return sum;
}

void add_wrench(const std::array<Vec3, 3>& wrench, Slot a, Slot b, std::span<Wrench> wrenches) {
  Wrench &of_a = wrenches[static_cast<std::size_t>(a)], &of_b = wrenches[static_cast<std::size_t>(b)];
  add(of_a.force, wrench[0]), add(of_a.torque, wrench[1]);
  add(of_b.force, -wrench[0]), add(of_b.torque, wrench[2]);
}

}  // namespace

void JointBatch::add_impulses(std::span<const SolverBody> bodies, std::span<Wrench> wrenches) const {
  for (const Part& part : parts_)
    with_joint_type(part.type, [&]<class T>() {
      add_wrench(wrench_of(evaluate<T>(part, bodies), part.lambda), part.side[0].slot, part.side[1].slot, wrenches);
    });
}

void JointBatch::sweep_jacobi(std::span<const SolverBody> bodies, std::span<Wrench> wrenches, double beta, SweepSums& sums) {
  const double per_unit = 1 / sums.unit;
  solve_trees(bodies, true);
  for (Part& part : parts_)
    with_joint_type(part.type, [&]<class T>() {
      const Step<T> step = part.link < 0 ? step_from<T>(part, part.y, bodies, true) : step_in_tree<T>(part, part.y, bodies);
      std::array<double, T::rows> moved;
      double gradient = 0, progress = 0;
      for (std::size_t k = 0; k < T::rows; ++k) {
        const double next = step.next[k], forward = next - part.lambda[k], y = next + beta * forward;
        gradient += step.defect[k] * forward, progress += step.defect[k] * (part.y[k] - next);
        if (next != part.y[k]) sums.change = std::max(sums.change, step_ * length_of<T>(part, k, step.defect[k]));
        moved[k] = y - part.y[k];
        part.lambda[k] = next, part.y[k] = y;
      }
      sums.largest = std::max(sums.largest, std::max(std::abs(gradient), progress));
      if (part.counted) sums.gradient += whole_units(gradient, per_unit), sums.progress += whole_units(progress, per_unit);
      add_wrench(wrench_of(step.rows, moved), part.side[0].slot, part.side[1].slot, wrenches);
    });
}

// Applies a step of a part's multipliers to its bodies; returns the largest change (m).
template <class T>
double JointBatch::push(Part& part, const Step<T>& step, std::span<SolverBody> bodies) const {
  double change = 0;
  std::array<double, T::rows> moved;
  for (std::size_t k = 0; k < T::rows; ++k) {
    if (step.next[k] != part.lambda[k]) change = std::max(change, step_ * length_of<T>(part, k, step.defect[k]));
    moved[k] = step.next[k] - part.lambda[k], part.lambda[k] = step.next[k];
  }
  const std::array<Vec3, 3> wrench = wrench_of(step.rows, moved);
  const auto add_to = [&](const Side& side, const Vec3& impulse, const Vec3& torque) {
    SolverBody& body = bodies[static_cast<std::size_t>(side.slot)];
    const Vec3 v = side.inverse_mass * impulse, w = side.inverse_inertia * torque;
    for (int k = 0; k < 3; ++k) body.v[k] += v[k], body.w[k] += w[k];
  };
  add_to(part.side[0], wrench[0], wrench[1]), add_to(part.side[1], -wrench[0], wrench[2]);
  return change;
}

double JointBatch::relax(std::size_t colour, std::span<SolverBody> bodies) {
  double change = 0;
  for (std::size_t i = colour == 0 ? 0 : colour_end_[colour - 1]; i < colour_end_[colour]; ++i) {
    Part& part = parts_[i];
    if (part.link >= 0) continue;
    with_joint_type(part.type, [&]<class T>() {
      change = std::max(change, push<T>(part, step_from<T>(part, part.lambda, bodies, false), bodies));
    });
  }
  return change;
}

double JointBatch::relax_trees(std::span<SolverBody> bodies) {
  double change = 0;
  solve_trees(bodies, false);
  for (Part& part : parts_)
    if (part.link >= 0)
      with_joint_type(part.type, [&]<class T>() {
        change = std::max(change, push<T>(part, step_in_tree<T>(part, part.lambda, bodies), bodies));
      });
  return change;
}

double JointBatch::residual(std::span<const SolverBody> bodies) const {
  double worst = 0;
  for (const Part& part : parts_)
    with_joint_type(part.type, [&]<class T>() {
      const Step<T> step = step_from<T>(part, part.lambda, bodies, false);
      for (std::size_t k = 0; k < T::rows; ++k)
        if (step.next[k] != part.lambda[k])
          worst = std::max(worst, (step_ + part.damping) * length_of<T>(part, k, step.defect[k]));
    });
  return worst;
}

}  // namespace unibody
