// The factor by which Jacobi solvers divide steps, against eigenvalues: of one body's directions, and of whole nets of links.
#include "constraints/direction_sum.hpp"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <functional>
#include <random>

#include "constraints/constraint_batch.hpp"
#include "constraints/constraint_types.hpp"

namespace unibody::direction_sum_test {
namespace {

Vec3x4 same_in_all_lanes(const Vec3& d) { return {broadcast(d.x()), broadcast(d.y()), broadcast(d.z())}; }

double largest(const Eigen::MatrixXd& A) { return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(A).eigenvalues().maxCoeff(); }

TEST(DirectionSum, BoundsItsLargestEigenvalue) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  for (int round = 0; round < 500; ++round) {
    std::array<DirectionSum, lanes> sums;
    std::array<Mat3, lanes> exact;
    for (std::size_t l = 0; l < lanes; ++l) {
      exact[l] = (round % 3) * Mat3::Identity();
      sums[l].add_any(round % 3);
      for (int k = 0; k < 1 + round % 20; ++k) {
        // Flat ones, and nearly parallel ones, among them.
        const Vec3 d(normal(random), round % 5 < 2 ? 1e-3 * normal(random) : normal(random), round % 2 ? 0 : normal(random));
        Directions(same_in_all_lanes(d), broadcast(1 / d.squaredNorm())).add_to(sums[l], l);
        exact[l] += d * d.transpose() / d.squaredNorm();
      }
      EXPECT_EQ(sums[l].squares[3], round % 3 + 1 + round % 20);  // their number
    }
    const Vec4d bound = largest_eigenvalues(sums);
    for (std::size_t l = 0; l < lanes; ++l) {
      EXPECT_GE(bound[l], largest(exact[l]) * (1 - 1e-14));
      EXPECT_LE(bound[l], largest(exact[l]) * std::pow(3, 1. / 16) * (1 + 1e-14));
    }
    // No less than asked for, whatever the other three are.
    for (const double share : {0.2, 0.6, 0.9, 1.1}) {
      const Vec4d least{share * bound[0], 0, bound[2] / share, share * bound[3]}, found = largest_eigenvalues(sums, least);
      for (std::size_t l = 0; l < lanes; ++l) EXPECT_NEAR(found[l], std::max(bound[l], least[l]), 1e-14 * found[l]);
    }
  }
}

// Links between points of a grid, structural ones and diagonals, in a plane that is tilted, or a heap of points joined at random.
struct Net {
  std::vector<Constraint<Distance>> links;
  std::vector<Vec4d> places;  // and 1/m; the last is nobody
  std::vector<SolverBody> bodies;

  void add_link(std::size_t a, std::size_t b) {
    auto& link = links.emplace_back();
    link.ids = {static_cast<Id>(a), static_cast<Id>(b)}, link.parameters = {1};
  }
  std::size_t size() const { return places.size() - 1; }
  Vec3 unit(const Constraint<Distance>& link) const {
    const Vec4d d = places[static_cast<std::size_t>(link.ids[0])] - places[static_cast<std::size_t>(link.ids[1])];
    return Vec3(d[0], d[1], d[2]).normalized();
  }

  std::vector<double> sharers() const {
    ConstraintBatch<Distance> batch;
    std::vector<std::uint32_t> order(links.size());
    for (std::uint32_t i = 0; i < order.size(); ++i) order[i] = i;
    const std::vector<std::uint32_t> groups{static_cast<std::uint32_t>(links.size())};
    batch.lay_out(
        links, order, groups, static_cast<Slot>(size()), Form::incremental,
        [&](std::uint32_t i) {
          return std::array<Slot, 2>{static_cast<Slot>(links[i].ids[0]), static_cast<Slot>(links[i].ids[1])};
        },
        [](std::uint32_t) { return true; });
    std::vector<DirectionSum> sums((places.size() + lanes - 1) / lanes * lanes);
    batch.add_directions({places, 0.01}, bodies, sums);
    std::vector<double> found;
    for (std::size_t i = 0; i < size(); ++i)
      found.push_back(largest_eigenvalues(std::span(sums).subspan(i / lanes * lanes).first<lanes>())[i % lanes]);
    return found;
  }

  // The stiffest mode of D W D^T beside the scaling diag(sum c_b / m_b).
  double stiffest_mode(const std::vector<double>& c) const {
    Eigen::MatrixXd D = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(links.size()), 3 * static_cast<Eigen::Index>(size()));
    for (std::size_t i = 0; i < links.size(); ++i) {
      double scale = 0;
      for (const Id id : links[i].ids) scale += c[static_cast<std::size_t>(id)] * places[static_cast<std::size_t>(id)][3];
      for (int e = 0; e < 2; ++e) {
        const Id b = links[i].ids[static_cast<std::size_t>(e)];
        const double weight = std::sqrt(places[static_cast<std::size_t>(b)][3] / scale);
        D.block<1, 3>(static_cast<Eigen::Index>(i), 3 * b) = (e == 0 ? weight : -weight) * unit(links[i]).transpose();
      }
    }
    return largest(D * D.transpose());
  }

  std::vector<double> counts() const {
    std::vector<double> n(size(), 0);
    for (const auto& link : links)
      for (const Id id : link.ids) ++n[static_cast<std::size_t>(id)];
    return n;
  }
};

Net net_of(std::vector<Vec3> points, const std::function<double(std::size_t)>& inverse_mass) {
  Net net;
  for (std::size_t i = 0; i < points.size(); ++i)
    net.places.push_back(Vec4d{points[i].x(), points[i].y(), points[i].z(), inverse_mass(i)});
  net.places.push_back(Vec4d{0, 0, 0, 0});
  net.bodies.assign(net.places.size(), SolverBody{});
  return net;
}

// On a flat cloth the bound is all but reached, so that steps cannot be longer; by their number they are about half as long.
TEST(DirectionSum, AFlatClothStepsTwiceAsFarAsByCounts) {
  constexpr std::size_t n = 12;
  const Mat3 tilt = Quat(1, 0.3, -0.2, 0.5).normalized().toRotationMatrix();
  std::vector<Vec3> points;
  for (std::size_t i = 0; i < n * n; ++i) points.push_back(tilt * Vec3(double(i % n), double(i / n), 0));
  Net net = net_of(points, [](std::size_t) { return 1; });
  for (std::size_t j = 0; j < n; ++j)
    for (std::size_t i = 0; i < n; ++i) {
      if (i + 1 < n) net.add_link(i + n * j, i + 1 + n * j);
      if (j + 1 < n) net.add_link(i + n * j, i + n * (j + 1));
      if (i + 1 < n && j + 1 < n) net.add_link(i + n * j, i + 1 + n * (j + 1)), net.add_link(i + 1 + n * j, i + n * (j + 1));
    }
  const double mode = net.stiffest_mode(net.sharers());
  EXPECT_LE(mode, 1);
  EXPECT_GE(mode, 0.9);
  EXPECT_LE(net.stiffest_mode(net.counts()), 0.55);
}

// Whatever masses and directions: no mode is stiffer than the scaling. On a straight chain it is that of counts.
TEST(DirectionSum, BoundsEveryNet) {
  std::mt19937 random(8);
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (int round = 0; round < 40; ++round) {
    std::vector<Vec3> points;
    for (int i = 0; i < 15; ++i) points.push_back(Vec3(uniform(random), uniform(random), round % 2 ? 0.1 * uniform(random) : 0));
    Net net = net_of(points, [&](std::size_t i) { return i == 0 ? 0 : std::pow(10, 2 * uniform(random)); });
    for (std::size_t i = 0; i < 15; ++i)
      for (std::size_t j = 0; j < i; ++j)
        if (uniform(random) < 0.2) net.add_link(i, j);
    EXPECT_LE(net.stiffest_mode(net.sharers()), 1 + 1e-12);
  }
  std::vector<Vec3> points;
  for (int i = 0; i < 9; ++i) points.push_back(Vec3(0.3, 0.4, 1.2) * i);
  Net chain = net_of(points, [](std::size_t) { return 1; });
  for (std::size_t i = 0; i + 1 < points.size(); ++i) chain.add_link(i, i + 1);
  for (std::size_t i = 0; i < points.size(); ++i) EXPECT_NEAR(chain.sharers()[i], chain.counts()[i], 1e-12);
}

}  // namespace
}  // namespace unibody::direction_sum_test
