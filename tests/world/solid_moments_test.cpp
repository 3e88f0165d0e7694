// Mass properties of hulls, meshes and compounds against closed forms.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "world/shape_library.hpp"

namespace unibody::solid_moments_test {

namespace {

// A tetrahedron with its right angle at the origin and legs a, b, c: V = abc/6, centre (a, b, c)/4, and about the centre
// the second moments 3/80 of the squares and -1/80 of the products.
TEST(SolidMoments, OfARightAngledTetrahedron) {
  const double a = 0.3, b = 0.5, c = 0.9;
  const std::vector<Vec3> nodes{{0, 0, 0}, {a, 0, 0}, {0, b, 0}, {0, 0, c}};
  const std::vector<std::array<std::int32_t, 3>> faces{{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  const SolidMoments m = solid_moments(nodes, faces);
  EXPECT_NEAR(m.volume, a * b * c / 6, 1e-15);
  EXPECT_LT((m.centre - Vec3(a, b, c) / 4).norm(), 1e-15);
  Mat3 second;
  second << 3 * a * a, -a * b, -a * c, -a * b, 3 * b * b, -b * c, -a * c, -b * c, 3 * c * c;
  second /= 80;
  const Mat3 expected = second.trace() * Mat3::Identity() - second, turn = m.axes.toRotationMatrix();
  EXPECT_LT((turn * m.inertia.asDiagonal() * turn.transpose() - expected).norm(), 1e-14);
  EXPECT_NEAR(turn.determinant(), 1, 1e-12);
}

TEST(SolidMoments, OfABoxAnywhere) {
  const Vec3 half(0.2, 0.3, 0.5), far(100, -200, 300);
  const Quat turn(Eigen::AngleAxisd(0.7, Vec3(1, 2, 3).normalized()));
  std::vector<Vec3> points;
  for (int k = 0; k < 8; ++k)
    points.push_back(far + turn * Vec3(k & 1 ? 1 : -1, k & 2 ? 1 : -1, k & 4 ? 1 : -1).cwiseProduct(half));
  points.push_back(far);  // inside: no corner
  const Hull hull = make_hull(points);
  EXPECT_EQ(hull.corners.size(), 8u);
  EXPECT_EQ(hull.faces.size(), 6u);
  for (const Hull::Face& f : hull.faces) EXPECT_EQ(f.count, 4u);
  EXPECT_NEAR(hull.volume, 8 * half.prod(), 1e-10);
  EXPECT_LT((hull.centre - far).norm(), 1e-10);
  const Vec3 s = half.cwiseProduct(half);
  Vec3 expected = Vec3(s.y() + s.z(), s.z() + s.x(), s.x() + s.y()) / 3, found = hull.inertia;
  std::sort(expected.data(), expected.data() + 3), std::sort(found.data(), found.data() + 3);
  EXPECT_LT((expected - found).norm(), 1e-10);
}

// A ball of 1,500 random points on a sphere; corners and faces follow Euler's formula.
TEST(Hull, OfPointsOnASphere) {
  std::mt19937 engine(1);
  std::normal_distribution<double> normal;
  std::vector<Vec3> points;
  for (int i = 0; i < 1500; ++i) points.push_back(Vec3(normal(engine), normal(engine), normal(engine)).normalized());
  const Hull hull = make_hull(points);
  EXPECT_EQ(hull.corners.size(), points.size());
  std::size_t triangles = 0;  // of which the faces are made: two of them may lie in one plane by chance
  for (const Hull::Face& f : hull.faces) triangles += f.count - 2;
  EXPECT_EQ(triangles, 2 * points.size() - 4);
  EXPECT_NEAR(hull.volume, 4 * std::numbers::pi / 3, 0.05);
  EXPECT_LT((hull.inertia - Vec3::Constant(0.4)).norm(), 0.01);
  for (const Hull::Face& f : hull.faces)
    for (const Vec3& x : hull.corners) ASSERT_LE(f.normal.dot(x - hull.corners[hull.face_corners[f.first]]), 2e-6);
}

TEST(Hull, WithoutVolumeIsRefused) {
  const std::vector<Vec3> three{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, flat{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}, {0.3, 0.2, 0}};
  const std::vector<Vec3> line{{0, 0, 0}, {1, 1, 1}, {2, 2, 2}, {3, 3, 3}}, same(5, Vec3(1, 2, 3));
  for (const auto& points : {three, flat, line, same}) EXPECT_THROW(make_hull(points), std::invalid_argument);
}

// Volumes and moments by counting the points of a fine grid.
TEST(Shapes, CapsuleAndCylinderAgainstSampling) {
  const int n = 160;
  for (const Shape& s : {Shape{ShapeKind::capsule, {0.3, 0.3, 0.7}}, Shape{ShapeKind::cylinder, {0.4, 0.4, 0.3}}}) {
    const double edge = 2 * s.size.maxCoeff() / n;
    double hits = 0;
    Vec3 squares = Vec3::Zero();
    for (int i = 0; i < n * n * n; ++i) {
      const Vec3 x = edge * (Vec3(i % n, i / n % n, i / n / n) + Vec3::Constant(0.5 - n / 2));
      const double h = s.size.z() - s.size.x(), beyond = std::max(0.0, std::abs(x.z()) - h), across = std::hypot(x.x(), x.y());
      const bool in = s.kind == ShapeKind::capsule ? std::hypot(across, beyond) <= s.size.x()
                                                   : across <= s.size.x() && std::abs(x.z()) <= s.size.z();
      if (in) ++hits, squares += x.cwiseProduct(x);
    }
    EXPECT_NEAR(volume(s), hits * edge * edge * edge, 0.005 * volume(s));
    const Vec3 sampled = (Vec3::Constant(squares.sum()) - squares) / hits, exact = inertia(s, 1);
    EXPECT_LT((sampled - exact).norm(), 0.005 * exact.norm());
  }
}

// Two balls on a bar of no weight: m (2/5 r^2) each, and m d^2 across.
TEST(Compound, MomentsOfADumbbell) {
  const Shape ball{ShapeKind::sphere, {0.1, 0, 0}};
  const Vec3 along = Vec3(1, 2, 2) / 3;
  const std::vector<Compound::Part> parts{{ball, 0.5 * along, Quat::Identity()}, {ball, -0.5 * along, Quat::Identity()}};
  const Compound c = make_compound(parts);
  Vec3 moments = c.inertia;
  std::sort(moments.data(), moments.data() + 3);
  EXPECT_NEAR(moments[0], 0.4 * 0.01, 1e-12);
  EXPECT_NEAR(moments[1], 0.4 * 0.01 + 0.25, 1e-12);
  EXPECT_NEAR(moments[2], 0.4 * 0.01 + 0.25, 1e-12);
  EXPECT_NEAR(c.radius, 0.6, 1e-12);
}

// A mesh finds the triangles that trying all of them finds.
TEST(MeshSurface, FindsTrianglesInABox) {
  std::mt19937 engine(4);
  std::uniform_real_distribution<double> any(-1, 1);
  std::vector<Vec3> nodes;
  std::vector<std::array<std::int32_t, 3>> triangles;
  for (std::int32_t i = 0; i < 500; ++i) {
    const Vec3 at(any(engine), any(engine), any(engine));
    for (int k = 0; k < 3; ++k) nodes.push_back(at + 0.05 * Vec3(any(engine), any(engine), any(engine)));
    triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  }
  const MeshSurface mesh = make_mesh_shape(nodes, triangles);
  for (int trial = 0; trial < 50; ++trial) {
    const Vec3 low(any(engine), any(engine), any(engine)), high = low + Vec3::Constant(0.3);
    std::vector<std::int32_t> found, expected;
    mesh.find(low, high, found);
    for (std::int32_t i = 0; i < 500; ++i) {
      Vec3 from = nodes[3 * i], to = from;
      for (int k = 1; k < 3; ++k) from = from.cwiseMin(nodes[3 * i + k]), to = to.cwiseMax(nodes[3 * i + k]);
      if ((from.array() <= high.array()).all() && (to.array() >= low.array()).all()) expected.push_back(i);
    }
    EXPECT_EQ(found, expected);
  }
}

}  // namespace

}  // namespace unibody::solid_moments_test
