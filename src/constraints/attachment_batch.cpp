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

}  // namespace

void AttachmentBatch::build(std::span<const AttachedNode> attached, std::span<const SolverBody> bodies,
                            std::span<const InverseInertia> inertia, std::span<const std::uint8_t> isotropic,
                            std::span<const std::int32_t> counts, double scaling, double step, std::size_t homes) {
  step_ = step;
  rows_.clear();
  rows_.reserve(attached.size());
  for (const AttachedNode& a : attached) {
    const auto body = static_cast<std::size_t>(a.body), node = static_cast<std::size_t>(a.node);
    const double of_body = std::max(1.0, scaling * counts[body]), of_node = std::max(1.0, scaling * counts[node]);
    const Mat3 arm = cross_matrix(a.arm), W = inverse_inertia_of(bodies, inertia, isotropic, body);
    const double linear = of_body * bodies[body].inverse_mass + of_node * bodies[node].inverse_mass;
    const Mat3 block = linear * Mat3::Identity() + of_body * (arm * W * arm.transpose());
    rows_.push_back({a.body, a.node, body < homes, a.arm, a.gap / step, block.inverse(), Vec3::Zero(), Vec3::Zero()});
  }
}

// m/s, what the velocities leave of the gap's closing.
Vec3 AttachmentBatch::defect(const Row& row, std::span<const SolverBody> bodies) {
  const SolverBody &b = bodies[static_cast<std::size_t>(row.body)], &n = bodies[static_cast<std::size_t>(row.node)];
  const Vec3 v(b.v[0], b.v[1], b.v[2]), w(b.w[0], b.w[1], b.w[2]), of_node(n.v[0], n.v[1], n.v[2]);
  return row.bias + v + w.cross(row.arm) - of_node;
}

void AttachmentBatch::sweep_jacobi(std::span<const SolverBody> bodies, std::span<Wrench> wrenches, const Extrapolation& beyond,
                                   SweepSums& sums) {
  const double per_unit = 1 / sums.unit;
  for (Row& row : rows_) {
    const Vec3 r = defect(row, bodies), step = -(row.inverse * r);
    const Vec3 next = row.y + step, forward = next - row.lambda, y = next + beyond.momentum * forward + beyond.overshoot * step,
               moved = y - row.y;
    row.lambda = next, row.y = y;
    const double gradient = r.dot(forward), progress = -r.dot(step);
    sums.largest = std::max(sums.largest, std::max(std::abs(gradient), progress));
    sums.change = std::max(sums.change, step_ * r.cwiseAbs().maxCoeff());
    if (row.counted) sums.gradient += whole_units(gradient, per_unit), sums.progress += whole_units(progress, per_unit);
    Wrench& of_body = wrenches[static_cast<std::size_t>(row.body)];
    add(of_body.force, moved), add(of_body.torque, row.arm.cross(moved));
    add(wrenches[static_cast<std::size_t>(row.node)].force, -moved);
  }
}

double AttachmentBatch::residual(std::span<const SolverBody> bodies) const {
  double worst = 0;
  for (const Row& row : rows_) worst = std::max(worst, defect(row, bodies).cwiseAbs().maxCoeff());
  return step_ * worst;
}

}  // namespace unibody
