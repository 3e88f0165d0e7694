// JointBatch: what of the rows is the same all through a step. Gradients are those at its start, and with them the blocks.
#include <cmath>

#include "joints/joint_batch.hpp"
#include "joints/joint_types.hpp"
#include "joints/semidefinite.hpp"

namespace unibody {

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

double JointBatch::least_diagonal(const Side& a, const Side& b, double share_a, double share_b, const Vec3& linear,
                                  const Vec3& angular, const Vec3& angular_b) {
  const double moves = (share_a * a.inverse_mass + share_b * b.inverse_mass) * linear.squaredNorm();
  const double turns =
      share_a * a.inverse_inertia.trace() * angular.squaredNorm() + share_b * b.inverse_inertia.trace() * angular_b.squaredNorm();
  return least_pivot * (moves + turns);
}

template <class T>
std::array<JointBatch::Row, T::rows> JointBatch::evaluate(const Part& part) {
  const SolverBody still{};
  const JointEnd a = end_of(part.side[0], still, 0), b = end_of(part.side[1], still, 0);
  JointRows<T::rows> at;
  T::evaluate(a, b, at);
  std::array<Row, T::rows> rows;
  for (std::size_t k = 0; k < T::rows; ++k)
    rows[k] = {at.linear[k], at.angular[k], other_angular(at.linear[k], at.angular[k], a, b), at.value[k]};
  return rows;
}

void JointBatch::prepare_rows() {
  rows_.clear();
  std::uint32_t block = 0;
  for (Part& part : parts_)
    with_joint_type(part.type, [&]<class T>() {
      part.row = static_cast<std::uint32_t>(rows_.size()), part.block = block;
      block += Semidefinite<T::rows>::size;
      const auto rows = evaluate<T>(part);
      rows_.insert(rows_.end(), rows.begin(), rows.end());
    });
  for (auto& blocks : blocks_) blocks.clear();
}

void JointBatch::prepare_blocks(bool shared) const {
  std::vector<double>& blocks = blocks_[shared ? 1 : 0];
  if (!blocks.empty() || parts_.empty()) return;
  with_joint_type(parts_.back().type, [&]<class T>() { blocks.resize(parts_.back().block + Semidefinite<T::rows>::size); });
  for (const Part& part : parts_)
    with_joint_type(part.type, [&]<class T>() { fill_block<T>(part, shared, blocks.data() + part.block); });
}

template <class T>
void JointBatch::fill_block(const Part& part, bool shared, double* P) const {
  using Block = Semidefinite<T::rows>;
  const Row* const at = &rows_[part.row];
  const Side &a = part.side[0], &b = part.side[1];
  const double share_a = shared ? a.share : 1, share_b = shared ? b.share : 1;
  const double mobility = share_a * a.inverse_mass + share_b * b.inverse_mass;
  for (std::size_t i = 0; i < T::rows; ++i) {
    const Vec3 turn_a = share_a * (a.inverse_inertia * at[i].angular), turn_b = share_b * (b.inverse_inertia * at[i].angular_b);
    for (std::size_t j = 0; j <= i; ++j)
      P[Block::at(i, j)] = mobility * at[i].linear.dot(at[j].linear) + turn_a.dot(at[j].angular) + turn_b.dot(at[j].angular_b);
    double& diagonal = P[Block::at(i, i)];
    if (!(diagonal > least_diagonal(a, b, share_a, share_b, at[i].linear, at[i].angular, at[i].angular_b))) diagonal = 0;
    diagonal += (i + T::angles < T::rows ? part.compliance : part.turning) / (step_ * (step_ + part.damping));
  }
  Block::factor(P);
}

void JointBatch::add_to_tree(Part& part, std::int32_t tree) {
  with_joint_type(part.type, [&]<class T>() {
    const std::array<Row, T::rows> at = evaluate<T>(part);
    JointTrees::Vector6 compliance = JointTrees::Vector6::Zero();
    std::array<JointTrees::Side, 2> sides;
    for (std::size_t e = 0; e < 2; ++e) {
      const Side& side = part.side[e];
      sides[e] = {side.slot, side.inverse_mass > 0, JointTrees::Matrix6::Zero()};
      const Mat3 turn = square_root_of(side.share * side.inverse_inertia);
      const double move = std::sqrt(side.share * side.inverse_mass) * (e == 0 ? 1 : -1);
      for (std::size_t k = 0; k < T::rows; ++k) {
        const auto row = static_cast<Eigen::Index>(k);
        sides[e].rows.row(row).head<3>() = move * at[k].linear.transpose();
        sides[e].rows.row(row).tail<3>() = (e == 0 ? at[k].angular : at[k].angular_b).transpose() * turn;
        compliance[row] = (k + T::angles < T::rows ? part.compliance : part.turning) / (step_ * (step_ + part.damping));
      }
    }
    for (std::size_t k = 0; k < T::rows; ++k) {
      const Side &a = part.side[0], &b = part.side[1];
      const auto row = static_cast<Eigen::Index>(k);
      const double diagonal = sides[0].rows.row(row).squaredNorm() + sides[1].rows.row(row).squaredNorm();
      if (!(diagonal > least_diagonal(a, b, a.share, b.share, at[k].linear, at[k].angular, at[k].angular_b)))
        sides[0].rows.row(row).setZero(), sides[1].rows.row(row).setZero();
    }
    part.link = static_cast<std::int32_t>(trees_.add(tree, sides[0], sides[1], compliance));
  });
}

}  // namespace unibody
