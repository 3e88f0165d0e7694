#include "constraints/attachment_batch.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace unibody {

namespace {

Mat3 cross_matrix(const Vec3& a) {
  Mat3 m;
  m << 0, -a.z(), a.y(), a.z(), 0, -a.x(), -a.y(), a.x(), 0;
  return m;
}

void add(Vec4d& to, const Vec3& x) { to += Vec4d{x.x(), x.y(), x.z(), 0}; }

// Adds an impulse (N s) that acts at the node's place: the body is pushed by it, and the node by its opposite.
void push(std::span<Wrench> wrenches, Slot body, Slot node, const Vec3& arm, const Vec3& impulse) {
  Wrench& of_body = wrenches[static_cast<std::size_t>(body)];
  add(of_body.force, impulse), add(of_body.torque, arm.cross(impulse));
  add(wrenches[static_cast<std::size_t>(node)].force, -impulse);
}

// m/s: by how much the mean velocity over the step of a point that turns with its body differs from that at the start, with the
// spin that is predicted.
Vec3 chord_less_tangent(const SolverBody& body, const Vec3& arm, double step) {
  const Vec3 w(body.w[0], body.w[1], body.w[2]), half = 0.5 * step * w;
  const Mat3 turn = Quat(1, half.x(), half.y(), half.z()).normalized().toRotationMatrix();  // as finish_motion() turns it
  return (turn * arm - arm) / step - w.cross(arm);
}

}  // namespace

void AttachmentBatch::build(const BuildContext& context) {
  const SolveState& state = context.state;
  const double scaling = context.settings.scaling;
  step_ = state.step, any_ = context.has_attachments;
  rows_.clear();
  if (!any_) return;
  std::pmr::vector<std::int32_t> own(context.memory);
  if (state.counts.empty()) {
    own.assign(state.bodies.size(), 0);
    count(context, own);
    context.exchange(own);
  }
  const std::span<const std::int32_t> counts = own.empty() ? state.counts : own;
  rows_.reserve(context.attached.size());
  for (const AttachedNode& a : context.attached) {
    const auto body = static_cast<std::size_t>(a.body), node = static_cast<std::size_t>(a.node);
    const double of_body = std::max(1.0, scaling * counts[body]), of_node = std::max(1.0, scaling * counts[node]);
    const Mat3 arm = cross_matrix(a.arm), W = inverse_inertia_of(state.bodies, state.inertia, state.isotropic, body);
    const double linear = of_body * state.bodies[body].inverse_mass + of_node * state.bodies[node].inverse_mass;
    const Mat3 block = linear * Mat3::Identity() + of_body * (arm * W * arm.transpose());
    const auto all = context.elements.attachments;
    const auto number = static_cast<std::size_t>(std::lower_bound(all.begin(), all.end(), a.ids) - all.begin());
    const Vec3 bias = a.gap / step_ + chord_less_tangent(state.bodies[body], a.arm, step_);
    rows_.push_back({number, a.body, a.node, body < state.homes, a.arm, bias, block.inverse(), Vec3::Zero(), Vec3::Zero()});
  }
}

// m/s, what the velocities leave of the gap's closing.
Vec3 AttachmentBatch::defect(const Row& row, std::span<const SolverBody> bodies) {
  const SolverBody &b = bodies[static_cast<std::size_t>(row.body)], &n = bodies[static_cast<std::size_t>(row.node)];
  const Vec3 v(b.v[0], b.v[1], b.v[2]), w(b.w[0], b.w[1], b.w[2]), of_node(n.v[0], n.v[1], n.v[2]);
  return row.bias + v + w.cross(row.arm) - of_node;
}

void AttachmentBatch::sweep(SolveState& state, const Extrapolation& extrapolation, SweepSums& sums) {
  const Update<double> update = update_of(extrapolation);
  const std::span<Wrench> wrenches = state.wrenches;
  for (Row& row : rows_) {
    const Vec3 r = defect(row, state.bodies), step = -(row.inverse * r);
    Vec3 moved;
    SweepTerms<double> terms;
    for (int k = 0; k < 3; ++k)
      moved[k] = update.advance(row.lambda[k], row.y[k], row.y[k] + step[k], step[k], r[k], -(r[k] * step[k]),
                                step_ * std::abs(r[k]), terms);
    add_terms(sums, terms, row.counted);
    push(wrenches, row.body, row.node, row.arm, moved);
  }
}

void AttachmentBatch::start_from(const History& history, const WarmStart& warm) {
  for (Row& row : rows_)
    for (std::size_t k = 0; k < 3 && row.number < history.size(); ++k)
      row.lambda[static_cast<Eigen::Index>(k)] = row.y[static_cast<Eigen::Index>(k)] = warm.share * history[row.number][k];
}

void AttachmentBatch::add_impulses(SolveState& state, const WarmStart& warm, double) const {
  if (!(warm.share > 0)) return;
  for (const Row& row : rows_) push(state.wrenches, row.body, row.node, row.arm, row.lambda);
}

void AttachmentBatch::add_applied(const SolveState&, std::span<Vec4d> impulses) const {
  for (const Row& row : rows_) add(impulses[static_cast<std::size_t>(row.node)], -row.y);
}

void AttachmentBatch::remember(History& history, double) const {
  std::ranges::fill(history, std::array{0.0, 0.0, 0.0});
  for (const Row& row : rows_)
    if (row.number < history.size()) history[row.number] = {row.lambda.x(), row.lambda.y(), row.lambda.z()};
}

// All at once, by masses split among them; from the multipliers themselves, which the momentum of Gauss-Seidel has moved.
double AttachmentBatch::relax(std::size_t, bool, SolveState& state) {
  SweepSums sums;
  for (Row& row : rows_) row.y = row.lambda;
  sweep(state, {}, sums);
  state.apply_wrenches();
  return sums.change;
}

double AttachmentBatch::residual(const SolveState& state) const {
  double worst = 0;
  for (const Row& row : rows_) worst = std::max(worst, defect(row, state.bodies).cwiseAbs().maxCoeff());
  return step_ * worst;
}

void AttachmentBatch::for_each_residual(const SolveState& state, const ResidualVisitor& visit) const {
  for (const Row& row : rows_) visit(step_ * defect(row, state.bodies).cwiseAbs().maxCoeff(), std::array{row.body, row.node});
}

}  // namespace unibody
