#include "joints/joint_batch.hpp"

#include <algorithm>
#include <cmath>

#include "core/capacity.hpp"
#include "joints/joint_types.hpp"
#include "joints/semidefinite.hpp"

namespace unibody {

template <class T>
struct JointBatch::Rows {
  const Row* start;
  std::array<double, T::rows> value;  // m or rad
};

// A step of the multipliers: where they come to, and P times what they moved by (m/s or rad/s), the gradient mapping.
template <class T>
struct JointBatch::Step {
  Rows<T> rows;
  std::array<double, T::rows> next, defect;
};

namespace {

// The multiplier that a step of 1 / P brings a row within limits to, its proximal map, from what it misses at each of them.
double within_limits(double lambda, double beyond_lower, double beyond_upper, double to_impulse) {
  const double up = lambda - beyond_lower * to_impulse, down = lambda - beyond_upper * to_impulse;
  return up > 0 ? up : down < 0 ? down : 0;
}

}  // namespace

namespace {

// The impulse (N s) from which a motor that presses starts its step: what it gave in the last step, or, where that was nearly all
// that it may give now, all of it. So a pressure that lasts does not have to be found again in each step.
double start_of_press(double most, double before) {
  constexpr double nearly_all = 0.9;
  return std::abs(before) >= nearly_all * most ? std::copysign(most, before) : before;
}

}  // namespace

// Leaves in change_ what the multipliers of the trees' joints are to change by.
void JointBatch::solve_trees(std::span<const SolverBody> bodies, bool extrapolated) {
  if (trees_.size() == 0) return;
  Ends ends;
  for (const Part& part : parts_)
    if (part.link >= 0)
      with_joint_type(part.type, [&]<class T>() {
        const auto r = residual_of<T>(part, evaluate_ahead<T>(part, bodies, ends), extrapolated ? part.y : part.lambda, bodies);
        for (std::size_t k = 0; k < T::rows; ++k)
          residual_[static_cast<std::size_t>(part.link)][static_cast<Eigen::Index>(k)] = r[k];
      });
  trees_.solve(residual_, change_);
}

// After solve_trees.
template <class T>
JointBatch::Step<T> JointBatch::step_in_tree(const Part& part, const std::array<double, 6>& from) const {
  const auto link = static_cast<std::size_t>(part.link);
  Step<T> step{{&rows_[part.row], {}}, {}, {}};
  for (std::size_t k = 0; k < T::rows; ++k) {
    const auto row = static_cast<Eigen::Index>(k);
    step.next[k] = from[k] + change_[link][row], step.defect[k] = residual_[link][row];
  }
  return step;
}

void JointBatch::start_from(const History& history, const WarmStart& warm) { set_impulses(history, warm.share); }

std::size_t JointBatch::bytes() const {
  return bytes_of(parts_) + bytes_of(rows_) + bytes_of(blocks_[0]) + bytes_of(blocks_[1]) + trees_.bytes();
}

void JointBatch::set_impulses(std::span<const JointImpulses> impulses, double share) {
  for (Part& part : parts_) {
    part.lambda.fill(0);
    if (part.presses)
      part.lambda[0] = start_of_press(step_ * part.upper, impulses[part.joint].value[part.first]);
    else if (share > 0 && part.link < 0)
      with_joint_type(part.type, [&]<class T>() {
        for (std::size_t k = 0; k < T::rows; ++k) part.lambda[k] = share * impulses[part.joint].value[part.first + k];
      });
    part.y = part.lambda;
  }
}

void JointBatch::remember(History& history, double) const {
  for (const Part& part : parts_)
    with_joint_type(
        part.type, [&]<class T>() { std::copy_n(part.lambda.begin(), T::rows, history[part.joint].value.begin() + part.first); });
}

// The rows with their values after the step; less of their curve the farther a body turns, and none at velocity level.
template <class T>
JointBatch::Rows<T> JointBatch::evaluate_ahead(const Part& part, std::span<const SolverBody> bodies, Ends& ends,
                                               bool as_they_are) const {
  Rows<T> rows{&rows_[part.row], {}};
  const SolverBody &of_a = bodies[static_cast<std::size_t>(part.side[0].slot)],
                   &of_b = bodies[static_cast<std::size_t>(part.side[1].slot)];
  const Vec3 along = velocity_of(of_a) - velocity_of(of_b), spin_a = spin_of(of_a), spin_b = spin_of(of_b);
  const double turn = step_ * step_ * std::max(spin_a.squaredNorm(), spin_b.squaredNorm());
  const double part_of_curve = as_they_are ? 1 : std::min(1.0, most_turn_of_rows * most_turn_of_rows / turn);
  JointRows<T::rows> ahead;
  if (stabilisation_ < 0) {
    if (ends.joint != part.joint)
      ends = {end_of(part.side[0], of_a, step_), end_of(part.side[1], of_b, step_), std::int64_t{part.joint}};
    T::evaluate(ends.a, ends.b, ahead);
  }
  for (std::size_t k = 0; k < T::rows; ++k) {
    const Row& row = rows.start[k];
    const double straight = row.value + step_ * (row.linear.dot(along) + row.angular.dot(spin_a) + row.angular_b.dot(spin_b));
    if (stabilisation_ >= 0) {
      rows.value[k] = straight - left_alone<T>(part, k, row.value);
      continue;
    }
    double curve = ahead.value[k] - straight;
    if (T::rows == 1 && T::angles == 1) curve = wrapped(curve);
    rows.value[k] = straight + part_of_curve * curve;
  }
  return rows;
}

// The value at which a joint's own rows are at rest, or where a spring is.
template <class T>
double JointBatch::rest_of(const Part& part) {
  return T::rows == 1 ? part.upper : 0;
}

// What the velocity level leaves for later steps of a row's error at the start of this one.
template <class T>
double JointBatch::left_alone(const Part& part, std::size_t row, double value) const {
  const double compliance = row + T::angles < T::rows ? part.compliance : part.turning;
  if (part.law == Law::rate || part.law == Law::place || compliance > 0 || part.damping > 0) return 0;
  if (part.law == Law::equal) return (1 - stabilisation_) * (value - rest_of<T>(part));
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
    // Of a length that is kept in a frame that turns the rate of change is 0, but not that along the axis at the step's start.
    const bool is_length = k + T::angles < T::rows;
    const Row& row = at.start[k];
    const double rate = is_length && stabilisation_ < 0
                            ? (at.value[k] - row.value) / step_
                            : row.linear.dot(along) + row.angular.dot(spin_a) + row.angular_b.dot(spin_b);
    const double compliance = is_length ? part.compliance : part.turning;
    double open = at.value[k] - rest_of<T>(part);
    if (T::rows == 1 && T::angles == 1) open = wrapped(open);
    if (part.law == Law::equal)
      r[k] = (open + compliance * lambda[k] / step_ + part.damping * rate) / (step_ + part.damping);
    else if (part.law == Law::rate)
      r[k] = rate - part.lower + compliance * lambda[k] / (step_ * step_);
    else if (T::angles > 0)
      r[k] = wrapped(at.value[k] - part.lower) / step_;
    else
      r[k] = (at.value[k] - part.lower) / step_;
  }
  return r;
}

// What a row misses at its upper or lower limit (m or rad), its spring's and its damper's share included. Both see only what is
// beyond the limit: up to there a rope is slack, however fast its ends part.
template <class T>
double JointBatch::beyond(const Part& part, const Rows<T>& at, bool upper, double lambda) const {
  const double limit = upper ? part.upper : part.lower, after = at.value[0] - limit, start = at.start[0].value - limit;
  double forces = (T::angles > 0 ? part.turning : part.compliance) * lambda;
  if (part.damping > 0) forces += part.damping * (after - (upper ? std::max(0.0, start) : std::min(0.0, start)));
  return after + forces / step_;
}

template <class T>
JointBatch::Step<T> JointBatch::step_from(const Part& part, const std::array<double, 6>& from, std::span<const SolverBody> bodies,
                                          Ends& ends, bool shared, bool as_they_are) const {
  using Block = Semidefinite<T::rows>;
  Step<T> step{evaluate_ahead<T>(part, bodies, ends, as_they_are), {}, {}};
  const Rows<T>& at = step.rows;
  const double* const P = &blocks_[shared ? 1 : 0][part.block];
  if (part.law == Law::equal) {
    step.defect = residual_of<T>(part, at, from, bodies);
    const auto change = Block::solve(P, step.defect);
    for (std::size_t k = 0; k < T::rows; ++k) step.next[k] = from[k] - change[k];
  } else {
    step.next[0] = from[0], step.defect[0] = 0;
    if (!(P[0] > 0)) return step;
    if (part.law == Law::within) {
      step.next[0] = within_limits(from[0], beyond<T>(part, at, false, from[0]), beyond<T>(part, at, true, from[0]),
                                   1 / ((step_ + part.damping) * P[0]));
    } else {
      const double most = step_ * part.upper;
      step.next[0] = std::clamp(from[0] - residual_of<T>(part, at, from, bodies)[0] / P[0], -most, most);
    }
    step.defect[0] = P[0] * (from[0] - step.next[0]);
  }
  return step;
}

// A row's value as a length (m).
template <class T>
double JointBatch::length_of(const Part& part, std::size_t row, double x) {
  return std::abs(x) * (row + T::angles < T::rows ? 1 : part.lever);
}

namespace {

// D lambda: on the first body, whose opposite is the second's, and the two torques.
template <std::size_t rows, class Row, std::size_t n>
std::array<Vec3, 3> wrench_of(const Row* at, const std::array<double, n>& lambda) {
  std::array<Vec3, 3> sum{Vec3::Zero(), Vec3::Zero(), Vec3::Zero()};
  for (std::size_t k = 0; k < rows; ++k)
    sum[0] += lambda[k] * at[k].linear, sum[1] += lambda[k] * at[k].angular, sum[2] += lambda[k] * at[k].angular_b;
  return sum;
}

void add_wrench(const std::array<Vec3, 3>& wrench, Slot a, Slot b, std::span<Wrench> wrenches) {
  Wrench &of_a = wrenches[static_cast<std::size_t>(a)], &of_b = wrenches[static_cast<std::size_t>(b)];
  add(of_a.force, wrench[0]), add(of_a.torque, wrench[1]);
  add(of_b.force, -wrench[0]), add(of_b.torque, wrench[2]);
}

}  // namespace

void JointBatch::add_impulses(SolveState& state, const WarmStart& warm, double) const {
  for (const Part& part : parts_) {
    if (warm.share <= 0 && !part.presses) continue;
    with_joint_type(part.type, [&]<class T>() {
      add_wrench(wrench_of<T::rows>(&rows_[part.row], part.lambda), part.side[0].slot, part.side[1].slot, state.wrenches);
    });
  }
}

void JointBatch::sweep(SolveState& state, const Extrapolation& extrapolation, SweepSums& sums) {
  const Update<double> update = update_of(extrapolation);
  const std::span<const SolverBody> bodies = state.bodies;
  prepare_blocks(true);
  solve_trees(bodies, true);
  Ends ends;
  for (Part& part : parts_)
    with_joint_type(part.type, [&]<class T>() {
      const Step<T> step = part.link < 0 ? step_from<T>(part, part.y, bodies, ends, true) : step_in_tree<T>(part, part.y);
      std::array<double, T::rows> moved;
      SweepTerms<double> terms;
      for (std::size_t k = 0; k < T::rows; ++k) {
        const double next = step.next[k], r = step.defect[k], by = next - part.y[k];
        const double change = by != 0 ? step_ * length_of<T>(part, k, r) : 0;
        moved[k] = update.advance(part.lambda[k], part.y[k], next, by, r, -(r * by), change, terms);
      }
      add_terms(sums, terms, part.counted);
      add_wrench(wrench_of<T::rows>(step.rows.start, moved), part.side[0].slot, part.side[1].slot, state.wrenches);
    });
}

// Applies a step of a part's multipliers to its bodies; returns the largest change (m).
template <class T>
double JointBatch::push(Part& part, const Step<T>& step, std::span<SolverBody> bodies, Ends& ends) const {
  double change = 0;
  std::array<double, T::rows> moved;
  for (std::size_t k = 0; k < T::rows; ++k) {
    if (step.next[k] != part.lambda[k]) change = std::max(change, step_ * length_of<T>(part, k, step.defect[k]));
    moved[k] = step.next[k] - part.lambda[k], part.lambda[k] = step.next[k];
  }
  if (std::ranges::any_of(moved, [](double m) { return m != 0; })) ends.joint = -1;
  const std::array<Vec3, 3> wrench = wrench_of<T::rows>(step.rows.start, moved);
  const auto add_to = [&](const Side& side, const Vec3& impulse, const Vec3& torque) {
    SolverBody& body = bodies[static_cast<std::size_t>(side.slot)];
    const Vec3 v = side.inverse_mass * impulse, w = side.inverse_inertia * torque;
    for (int k = 0; k < 3; ++k) body.v[k] += v[k], body.w[k] += w[k];
  };
  add_to(part.side[0], wrench[0], wrench[1]), add_to(part.side[1], -wrench[0], wrench[2]);
  return change;
}

double JointBatch::relax(std::size_t colour, bool, SolveState& state) {
  return colour < colour_end_.size() ? relax_colour(colour, state.bodies) : relax_trees(state.bodies);
}

double JointBatch::relax_colour(std::size_t colour, std::span<SolverBody> bodies) {
  double change = 0;
  Ends ends;
  prepare_blocks(false);
  for (std::size_t i = colour == 0 ? 0 : colour_end_[colour - 1]; i < colour_end_[colour]; ++i) {
    Part& part = parts_[i];
    if (part.link >= 0) continue;
    with_joint_type(part.type, [&]<class T>() {
      change = std::max(change, push<T>(part, step_from<T>(part, part.lambda, bodies, ends, false), bodies, ends));
    });
  }
  return change;
}

double JointBatch::relax_trees(std::span<SolverBody> bodies) {
  double change = 0;
  Ends ends;
  solve_trees(bodies, false);
  for (Part& part : parts_)
    if (part.link >= 0)
      with_joint_type(part.type, [&]<class T>() {
        change = std::max(change, push<T>(part, step_in_tree<T>(part, part.lambda), bodies, ends));
      });
  return change;
}

double JointBatch::residual_of(const Part& part, std::span<const SolverBody> bodies, Ends& ends) const {
  double worst = 0;
  with_joint_type(part.type, [&]<class T>() {
    const Step<T> step = step_from<T>(part, part.lambda, bodies, ends, false, true);
    for (std::size_t k = 0; k < T::rows; ++k)
      if (step.next[k] != part.lambda[k]) worst = std::max(worst, (step_ + part.damping) * length_of<T>(part, k, step.defect[k]));
  });
  return worst;
}

double JointBatch::residual(const SolveState& state) const {
  double worst = 0;
  Ends ends;
  prepare_blocks(false);
  for (const Part& part : parts_) worst = std::max(worst, residual_of(part, state.bodies, ends));
  return worst;
}

void JointBatch::for_each_residual(const SolveState& state, const ResidualVisitor& visit) const {
  Ends ends;
  prepare_blocks(false);
  for (const Part& part : parts_) visit(residual_of(part, state.bodies, ends), std::array{part.side[0].slot, part.side[1].slot});
}

}  // namespace unibody
