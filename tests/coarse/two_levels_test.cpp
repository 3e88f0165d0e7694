// The matrix, the coarse space and conjugate gradients, against dense matrices.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "coarse/conjugate_gradients.hpp"
#include "collide/bodies.hpp"

namespace unibody::two_levels_test {

namespace {

using samples::Random;

// A square net of springs of random stiffness in random directions on masses of 1 kg; the first node is held.
struct Net {
  static constexpr double mass = 1;
  const int side;
  const std::size_t n;
  std::vector<Id> ids;
  std::vector<Vec3> places;
  std::vector<std::uint8_t> moves;
  BlockMatrix matrix;
  std::vector<Mat3> inverse;

  explicit Net(int nodes, double stiffness = 1e4) : side(nodes), n(static_cast<std::size_t>(nodes * nodes)) {
    std::vector<std::pair<Slot, Slot>> links, pairs;
    for (int j = 0; j < side; ++j)
      for (int i = 0; i < side; ++i) {
        const int k = i + side * j;
        ids.push_back(10 * k), places.emplace_back(0.1 * i, 0.1 * j, 0.02 * std::sin(0.3 * i + 0.7 * j));
        if (i + 1 < side) links.emplace_back(k, k + 1);
        if (j + 1 < side) links.emplace_back(k, k + side);
        if (i + 1 < side && j + 1 < side) links.emplace_back(k, k + side + 1);
      }
    for (const auto& [a, b] : links)
      for (const Slot row : {a, b})
        for (const Slot column : {b, a}) pairs.emplace_back(row, column);
    matrix.set_pattern(pairs, ids);
    moves.assign(n, 1), moves[0] = 0;
    for (std::size_t r = 0; r < matrix.rows(); ++r) add(matrix.slot_of(r), matrix.slot_of(r), mass * Mat3::Identity());
    Random random(3);
    for (const auto& [a, b] : links) add_link(a, b, stiffness * random(0.5, 2));
    for (std::size_t r = 0; r < n; ++r) inverse.push_back(block(matrix.diagonal_of(r)).inverse());
  }

  void add_link(Slot a, Slot b, double stiffness) {
    const Vec3 along = (places[static_cast<std::size_t>(a)] - places[static_cast<std::size_t>(b)]).normalized();
    const Mat3 K = stiffness * (along * along.transpose() + 0.1 * Mat3::Identity());
    for (const Slot row : {a, b})
      for (const Slot column : {a, b})
        if (row != 0 && column != 0) add(row, column, row == column ? K : Mat3(-K));
  }

  void add(Slot row, Slot column, const Mat3& K) {
    BlockMatrix::Block& to = matrix.block(static_cast<std::size_t>(matrix.place_of(row, column)));
    for (int c = 0; c < 3; ++c) to[static_cast<std::size_t>(c)] += Vec4d{K(0, c), K(1, c), K(2, c), 0};
  }
  Mat3 block(std::size_t place) const {
    Mat3 K;
    for (int c = 0; c < 3; ++c) K.col(c) = to_vec3(matrix.block(place)[static_cast<std::size_t>(c)]);
    return K;
  }
  Eigen::MatrixXd dense() const {
    const auto size = static_cast<Eigen::Index>(3 * n);
    Eigen::MatrixXd H = Eigen::MatrixXd::Zero(size, size);
    for (std::size_t r = 0; r < n; ++r)
      for (std::size_t k = matrix.begin_of(r); k < matrix.end_of(r); ++k)
        H.block<3, 3>(3 * matrix.slot_of(r), 3 * matrix.column_of(k)) = block(k);
    return H;
  }

  CoarseSpace coarse_space() const {
    std::vector<std::int32_t> of(n);
    for (std::size_t k = 0; k < n; ++k)
      of[k] = static_cast<std::int32_t>(k) % side / 8 + (side + 7) / 8 * (static_cast<std::int32_t>(k) / side / 8);
    CoarseSpace coarse;
    const int tiles = (side + 7) / 8;
    coarse.set(MPI_COMM_SELF, matrix, of, tiles * tiles, n, ids);
    coarse.factorise(matrix, places, moves);
    return coarse;
  }

  LinearReport solve(const CoarseSpace* coarse, const std::vector<Vec3>& right, std::vector<Vec3>& x, double share) const {
    const LinearSystem system{matrix, inverse, coarse, 2, MPI_COMM_SELF, [](std::span<Vec3>) {}};
    std::vector<Vec3> b = right;
    x.assign(n, Vec3::Zero());
    return conjugate_gradients(system, b, x, share, 1000);
  }
};

Eigen::Map<const Eigen::VectorXd> flat(const std::vector<Vec3>& v) {
  return {v.front().data(), 3 * static_cast<Eigen::Index>(v.size())};
}

std::vector<Vec3> random_vectors(std::size_t n, std::uint64_t seed) {
  Random random(seed);
  std::vector<Vec3> v;
  for (std::size_t i = 0; i < n; ++i) v.push_back(random.vector(-1, 1));
  v[0] = Vec3::Zero();  // is held
  return v;
}

}  // namespace

TEST(BlockMatrix, MultipliesAsTheDenseOne) {
  const Net net(9);
  const std::vector<Vec3> x = random_vectors(net.n, 5);
  std::vector<Vec3> y(net.n, Vec3::Zero());
  net.matrix.multiply(x, y);
  EXPECT_LT((flat(y) - net.dense() * flat(x)).norm(), 1e-12 * flat(y).norm());
  EXPECT_GE(net.matrix.place_of(0, 1), 0);
  EXPECT_EQ(net.matrix.place_of(0, 5), -1);
}

// A correction of H z, z a rigid motion of each aggregate, is z itself: the coarse matrix is P^T H P.
TEST(CoarseSpace, CorrectsRigidMotionsOfAggregatesExactly) {
  Net net(24);
  const CoarseSpace coarse = net.coarse_space();
  Random random(11);
  std::vector<Vec3> linear, turn;
  for (std::int32_t a = 0; a < coarse.count(); ++a) linear.push_back(random.vector(-1, 1)), turn.push_back(random.vector(-3, 3));
  std::vector<Vec3> z(net.n, Vec3::Zero()), right(net.n, Vec3::Zero()), found(net.n, Vec3::Zero());
  for (std::size_t k = 1; k < net.n; ++k) {
    const auto a = static_cast<std::size_t>(static_cast<int>(k) % net.side / 8 + 3 * (static_cast<int>(k) / net.side / 8));
    z[k] = linear[a] + turn[a].cross(net.places[k]);
  }
  net.matrix.multiply(z, right);
  double largest = 0;
  for (const Vec3& r : right) largest = std::max(largest, r.lpNorm<Eigen::Infinity>());
  coarse.correct(right, largest, found);
  EXPECT_LT((flat(found) - flat(z)).norm(), 1e-5 * flat(z).norm());  // sums are rounded, and the diagonal is lifted by 1e-9
  EXPECT_GT(flat(z).norm(), 1);
}

TEST(ConjugateGradients, SolveAsADenseFactorisation) {
  Net net(20);
  const CoarseSpace coarse = net.coarse_space();
  const std::vector<Vec3> right = random_vectors(net.n, 9);
  const Eigen::VectorXd expected = net.dense().ldlt().solve(flat(right));
  std::vector<Vec3> x;
  for (const CoarseSpace* level : {&coarse, static_cast<const CoarseSpace*>(nullptr)}) {
    const LinearReport report = net.solve(level, right, x, 1e-11);
    EXPECT_LT((flat(x) - expected).norm(), 1e-9 * expected.norm()) << (level != nullptr);
    EXPECT_LE(report.left, 1e-11);
    EXPECT_GT(report.iterations, 3);
  }
}

// With a coarse level the iterations hardly grow with the net; without it they grow with its width.
TEST(ConjugateGradients, IterationsDoNotGrowWithTheNet) {
  std::vector<int> with, without;
  for (const int side : {16, 64}) {
    Net net(side, 1e6);
    const CoarseSpace coarse = net.coarse_space();
    const std::vector<Vec3> right(net.n, Vec3(0, 0, -1));
    std::vector<Vec3> x;
    with.push_back(net.solve(&coarse, right, x, 1e-6).iterations);
    without.push_back(net.solve(nullptr, right, x, 1e-6).iterations);
  }
  EXPECT_LE(with[1], 2 * with[0]);
  EXPECT_LE(with[1], 30);
  EXPECT_GE(without[1], 3 * without[0]);
}

}  // namespace unibody::two_levels_test
