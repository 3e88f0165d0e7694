#include "joints/joint_trees.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <unordered_map>

namespace unibody {

namespace {

constexpr double least_pivot = 1e-10;  // of a row's diagonal

using Vector6 = JointTrees::Vector6;
using Matrix6 = JointTrees::Matrix6;

// A generalised inverse of P (lower triangle) by L D L^T: 0 in the rows whose pivot is round-off.
Matrix6 invert_semidefinite(Matrix6 P) {
  Vector6 inverse;
  for (int j = 0; j < 6; ++j) {
    const double pivot = P(j, j) - (P.row(j).head(j).array().square() * inverse.head(j).transpose().array()).sum();
    inverse[j] = pivot > least_pivot * P(j, j) ? 1 / pivot : 0;
    for (int i = j + 1; i < 6; ++i)
      for (int k = 0; k < j; ++k) P(i, j) -= P(i, k) * P(j, k) * inverse[k];
  }
  Matrix6 result = Matrix6::Zero();
  for (int c = 0; c < 6; ++c) {
    if (inverse[c] == 0) continue;
    Vector6 x = Vector6::Unit(c);
    for (int j = 0; j < 6; ++j)
      for (int k = 0; k < j; ++k) x[j] -= P(j, k) * inverse[k] * x[k];
    for (int i = 5; i >= 0; --i) {
      x[i] *= inverse[i];
      for (int k = i + 1; k < 6; ++k) x[i] -= P(k, i) * inverse[i] * x[k];
    }
    result.col(c) = x;
  }
  return result;
}

}  // namespace

std::size_t JointTrees::size() const { return links_.size(); }

void JointTrees::Node::solve(Vector6& x) const {
  factor.triangularView<Eigen::Lower>().solveInPlace(x);
  factor.transpose().triangularView<Eigen::Upper>().solveInPlace(x);
}

void JointTrees::clear() { links_.clear(), nodes_.clear(); }

std::size_t JointTrees::add(std::int32_t tree, const Side& a, const Side& b, const Vector6& compliance) {
  links_.push_back({tree, {a, b}, compliance});
  return links_.size() - 1;
}

// Bodies of each tree from its root outwards. The root is a body that a joint ties to what does not move, or the first body of
// the tree's first joint. Where joints have broken, each piece of a tree is one of its own.
void JointTrees::find_order() {
  nodes_.clear();
  std::unordered_map<Slot, std::vector<std::int32_t>> at;  // joints of each body, ascending
  std::unordered_map<std::int32_t, std::size_t> root;      // of each tree: the joint from which it grows
  std::vector<std::int32_t> trees;
  for (std::size_t i = 0; i < links_.size(); ++i) {
    const Link& link = links_[i];
    for (const Side& side : link.side)
      if (side.moves) at[side.slot].push_back(static_cast<std::int32_t>(i));
    if (root.emplace(link.tree, i).second) trees.push_back(link.tree);
    if (!link.side[0].moves || !link.side[1].moves) root[link.tree] = i;
  }
  const auto is_held = [](const Link& link) { return !link.side[0].moves || !link.side[1].moves; };
  const auto grow = [&](std::size_t from_link) {
    Link& first = links_[from_link];
    std::vector<std::pair<Slot, std::size_t>> queue;  // a body and its place in nodes_
    const auto reach = [&](Link& link, std::size_t side, std::int32_t from) {
      queue.emplace_back(link.side[side].slot, nodes_.size());
      link.node[side] = static_cast<std::int32_t>(nodes_.size()), link.lower = side;
      nodes_.push_back({from});
    };
    reach(first, first.side[0].moves ? 0 : 1, is_held(first) ? static_cast<std::int32_t>(from_link) : -1);
    for (std::size_t next = 0; next < queue.size(); ++next) {
      const auto [slot, node] = queue[next];
      for (const std::int32_t i : at[slot]) {
        Link& link = links_[static_cast<std::size_t>(i)];
        if (i == nodes_[node].link) continue;
        const std::size_t near = link.side[0].slot == slot && link.side[0].moves ? 0 : 1;
        link.node[near] = static_cast<std::int32_t>(node);
        if (link.side[1 - near].moves) reach(link, 1 - near, i);
      }
    }
  };
  for (const std::int32_t tree : trees) grow(root[tree]);
  for (const bool held : {true, false})
    for (std::size_t i = 0; i < links_.size(); ++i)
      if (links_[i].node[0] < 0 && links_[i].node[1] < 0 && (!held || is_held(links_[i]))) grow(i);
}

void JointTrees::factor() {
  find_order();
  std::vector<Matrix6> sums(nodes_.size(), Matrix6::Identity());
  for (std::size_t n = nodes_.size(); n-- > 0;) {
    Node& node = nodes_[n];
    node.factor = Eigen::LLT<Matrix6>(sums[n]).matrixL();
    if (node.link < 0) continue;
    Link& link = links_[static_cast<std::size_t>(node.link)];
    const Matrix6 half = node.factor.triangularView<Eigen::Lower>().solve(link.below().transpose());
    Matrix6 P = half.transpose() * half;
    P.diagonal() += link.compliance;
    link.inverse = invert_semidefinite(P);
    if (link.parent() >= 0)
      sums[static_cast<std::size_t>(link.parent())] += link.above().transpose() * link.inverse * link.above();
  }
}

void JointTrees::solve(std::span<const Vector6> residual, std::span<Vector6> change) {
  for (Node& node : nodes_) node.z.setZero();
  for (std::size_t n = nodes_.size(); n-- > 0;) {
    Node& node = nodes_[n];
    node.solve(node.z);
    if (node.link < 0) continue;
    Link& link = links_[static_cast<std::size_t>(node.link)];
    link.right = -residual[static_cast<std::size_t>(node.link)] - link.below() * node.z;
    if (link.parent() >= 0)
      nodes_[static_cast<std::size_t>(link.parent())].z += link.above().transpose() * Vector6(link.inverse * link.right);
  }
  for (Node& node : nodes_) {
    if (node.link < 0) continue;
    const Link& link = links_[static_cast<std::size_t>(node.link)];
    Vector6 right = link.right;
    if (link.parent() >= 0) right -= link.above() * nodes_[static_cast<std::size_t>(link.parent())].z;
    const Vector6 moved = link.inverse * right;
    change[static_cast<std::size_t>(node.link)] = moved;
    Vector6 pushed = link.below().transpose() * moved;
    node.solve(pushed);
    node.z += pushed;
  }
}

std::size_t JointTrees::bytes() const { return links_.capacity() * sizeof(Link) + nodes_.capacity() * sizeof(Node); }

}  // namespace unibody
