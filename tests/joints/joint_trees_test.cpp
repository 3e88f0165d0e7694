// Trees of joints: their direct solve against a dense one, and which joints make a tree.
#include "joints/joint_trees.hpp"

#include <gtest/gtest.h>

#include <random>

#include "joints/joint_set.hpp"

namespace unibody::joint_trees_test {
namespace {

using Vector6 = JointTrees::Vector6;
using Matrix6 = JointTrees::Matrix6;

struct Tie {
  Slot a, b;  // the last slot does not move
  int rows;
};

// Random rows of each joint, once for the tree and once as columns of a dense system of all bodies.
void compare(const std::vector<Tie>& ties, const std::vector<std::int32_t>& tree, Slot bodies, double softness) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> draw(-1, 1);
  JointTrees trees;
  const auto n = static_cast<Eigen::Index>(6 * ties.size());
  Eigen::MatrixXd J = Eigen::MatrixXd::Zero(n, 6 * bodies), E = Eigen::MatrixXd::Zero(n, n);
  std::vector<Vector6> residual(ties.size()), change(ties.size());
  Eigen::VectorXd r(n);
  for (std::size_t i = 0; i < ties.size(); ++i) {
    const Tie& tie = ties[i];
    const auto first = static_cast<Eigen::Index>(6 * i);
    JointTrees::Side sides[2] = {{tie.a, tie.a < bodies, Matrix6::Zero()}, {tie.b, tie.b < bodies, Matrix6::Zero()}};
    residual[i].setZero();
    for (int k = 0; k < tie.rows; ++k) {
      residual[i][k] = draw(random);
      for (JointTrees::Side& side : sides)
        for (int c = 0; c < 6 && side.moves; ++c) side.rows(k, c) = draw(random);
    }
    for (const JointTrees::Side& side : sides)
      if (side.moves) J.block<6, 6>(first, 6 * side.slot) = side.rows;
    E.block<6, 6>(first, first).diagonal().setConstant(softness);
    r.segment<6>(first) = residual[i];
    trees.add(tree[i], sides[0], sides[1], Vector6::Constant(softness));
  }
  trees.factor();
  trees.solve(residual, change);
  const Eigen::VectorXd exact = -(J * J.transpose() + E).completeOrthogonalDecomposition().solve(r);
  for (std::size_t i = 0; i < ties.size(); ++i)
    EXPECT_LT((change[i] - exact.segment<6>(static_cast<Eigen::Index>(6 * i))).norm(), 1e-9 * exact.norm()) << i;
}

Joint tie(Id a, Id b, JointKind kind = JointKind::ball) {
  Joint joint;
  joint.ids = {a, b}, joint.kind = kind;
  joint.anchor.fill(Vec3::Zero()), joint.frame.fill(Quat::Identity());
  return joint;
}

}  // namespace

// Two trees, one of which is held, with branches, the joints in no order and with either body first.
TEST(JointTrees, SolvesAsADenseSolveDoes) {
  const std::vector<Tie> ties{{1, 0, 3}, {2, 1, 5}, {1, 3, 3}, {6, 5, 4}, {9, 3, 5}, {4, 3, 6}, {5, 7, 3}, {8, 5, 1}};
  for (const double softness : {0.0, 0.2}) compare(ties, {0, 0, 0, 1, 0, 0, 1, 1}, 9, softness);
}

// Rows that a tree determines twice: two bodies that cannot turn, tied by six rows.
TEST(JointTrees, RowsThatSayNothingNewAreLeftAlone) {
  JointTrees trees;
  Matrix6 rows = Matrix6::Identity();
  rows.bottomRows<3>().setZero();
  trees.add(0, {0, true, rows}, {1, true, -rows}, Vector6::Zero());
  trees.factor();
  std::vector<Vector6> change(1);
  trees.solve(std::vector<Vector6>{Vector6::Constant(3)}, change);
  EXPECT_LT((change[0].head<3>() + Vec3::Constant(1.5)).norm(), 1e-14);
  EXPECT_EQ(change[0].tail<3>(), Vec3(Vec3::Zero()));
}

TEST(JointTrees, LoopsAndRopesAreLeftOut) {
  // 9 does not move. A ring 0-1-2, held once and then once more; a pair apart; a rope to it.
  std::vector<Joint> joints{tie(0, 1), tie(1, 2), tie(2, 0), tie(1, 9), tie(2, -1), tie(4, 5), tie(5, 0, JointKind::rope),
                            tie(9, 6)};
  EXPECT_EQ(plant_trees(joints, [](Id id) { return id == 9; }), 3);
  std::vector<std::int32_t> trees;
  for (const Joint& joint : joints) trees.push_back(joint.tree);
  EXPECT_EQ(trees, (std::vector<std::int32_t>{0, 0, -1, 0, -1, 1, -1, 2}));
  // Two held trees are not tied to each other by a third joint.
  std::vector<Joint> held{tie(0, -1), tie(1, -1), tie(0, 1)};
  EXPECT_EQ(plant_trees(held, [](Id) { return false; }), 2);
  EXPECT_EQ(held[2].tree, -1);
}

}  // namespace unibody::joint_trees_test
