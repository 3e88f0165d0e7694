// Trees of joints solved as one block: (J W J^T + E) d = -r for all rows of a tree at once, in a time that grows with the number
// of its joints (Baraff, Linear-time dynamics using Lagrange multipliers, 1996): from the leaves to the root, each body's and
// each joint's equation is eliminated, which fills nothing in, and back.
//
// W = S S^T, with the bodies' masses shared by their counts; in the variables z, u = S z, a body's pivot is I and what its
// branches add, so that nothing is divided by a mass and bodies that cannot turn about some axis need no rule. Rows that others
// of their joint determine are left alone, as by JointBatch. Joints of one rank-independent order are solved to the same bits on
// every rank that holds the tree.
#pragma once

#include <span>
#include <vector>

#include "core/types.hpp"

namespace unibody {

class JointTrees {
 public:
  using Vector6 = Eigen::Matrix<double, 6, 1>;
  using Matrix6 = Eigen::Matrix<double, 6, 6>;

  // One side of a joint: the body's slot, and its rows times S: 6 columns each, 0 of rows that the joint hasn't.
  struct Side {
    Slot slot;
    bool moves;  // else it is no part of the tree
    Matrix6 rows;
  };

  void clear();

  // A joint of a tree, the joints of all trees in one order of their own: its number is that of the call. compliance: E / (h (h +
  // rho)), of each row.
  std::size_t add(std::int32_t tree, const Side& a, const Side& b, const Vector6& compliance);

  // After the last add(): finds the order and factors.
  void factor();

  // The change of the multipliers for the residuals r of the joints' rows.
  void solve(std::span<const Vector6> residual, std::span<Vector6> change);

  std::size_t size() const;
  std::size_t bytes() const;

 private:
  struct Link {
    std::int32_t tree;
    std::array<Side, 2> side;
    Vector6 compliance;
    std::array<std::int32_t, 2> node{-1, -1};  // of the two bodies
    std::size_t lower = 0;                     // the side away from the root
    Matrix6 inverse = Matrix6::Zero();         // of the joint's pivot
    Vector6 right = Vector6::Zero();

    const Matrix6& below() const { return side[lower].rows; }
    const Matrix6& above() const { return side[1 - lower].rows; }
    std::int32_t parent() const { return node[1 - lower]; }
  };

  struct Node {
    std::int32_t link = -1;            // towards the root; -1: the root, free
    Matrix6 factor = Matrix6::Zero();  // L of the body's pivot L L^T
    Vector6 z = Vector6::Zero();

    void solve(Vector6& x) const;
  };

  void find_order();

  std::vector<Link> links_;
  std::vector<Node> nodes_;  // bodies, of each tree from the root outwards
};

}  // namespace unibody
