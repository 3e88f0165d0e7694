#include "world/solid_moments.hpp"

#include <Eigen/Eigenvalues>
#include <cmath>

namespace unibody {

namespace {

// The principal axes as columns, in the order and with the signs that make them most like the axes given.
Mat3 principal_axes(const Mat3& second) {
  const double largest = second.diagonal().cwiseAbs().maxCoeff();
  const Mat3 off = second - Mat3(second.diagonal().asDiagonal());
  if (off.cwiseAbs().maxCoeff() <= 1e-12 * largest) return Mat3::Identity();
  const Mat3 vectors = Eigen::SelfAdjointEigenSolver<Mat3>(second).eigenvectors();
  constexpr int orders[6][3] = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};
  double best = -1;
  Mat3 axes = Mat3::Identity();
  for (const auto& order : orders) {
    Mat3 candidate;
    for (int k = 0; k < 3; ++k) {
      const Vec3 v = vectors.col(order[k]);
      candidate.col(k) = v[k] < 0 ? Vec3(-v) : v;
    }
    const double trace = candidate.trace();
    if (trace > best) best = trace, axes = candidate;
  }
  if (axes.determinant() < 0) {  // turn over the axis that is least like its own
    int least = 0;
    for (int k = 1; k < 3; ++k)
      if (axes(k, k) < axes(least, least)) least = k;
    axes.col(least) = -axes.col(least);
  }
  return axes;
}

}  // namespace

SolidMoments moments_of(double volume, const Vec3& centre, const Mat3& second) {
  const Mat3 axes = principal_axes(second);
  const Vec3 along = (axes.transpose() * second * axes).diagonal();
  return {volume, centre, Vec3::Constant(along.sum()) - along, Quat(axes)};
}

SolidMoments solid_moments(std::span<const Vec3> nodes, std::span<const std::array<std::int32_t, 3>> triangles) {
  if (nodes.empty()) return {};
  Vec3 origin = Vec3::Zero();  // inside or near: sums lose no digits far from the world's origin
  for (const Vec3& x : nodes) origin += x / static_cast<double>(nodes.size());
  double volume = 0;
  Vec3 first = Vec3::Zero();
  Mat3 second = Mat3::Zero();
  for (const auto& t : triangles) {
    const Vec3 a = nodes[static_cast<std::size_t>(t[0])] - origin, b = nodes[static_cast<std::size_t>(t[1])] - origin,
               c = nodes[static_cast<std::size_t>(t[2])] - origin;
    const double v = a.dot(b.cross(c)) / 6;
    const Vec3 sum = a + b + c;
    volume += v;
    first += v / 4 * sum;
    second += v / 20 * (sum * sum.transpose() + a * a.transpose() + b * b.transpose() + c * c.transpose());
  }
  if (!(volume != 0)) return {};
  const Vec3 centre = first / volume;
  return moments_of(volume, origin + centre, second / volume - centre * centre.transpose());
}

}  // namespace unibody
