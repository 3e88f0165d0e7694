#include "world/shapes.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "collide/bodies.hpp"

namespace unibody::shapes_test {
namespace {

using samples::Random;

bool inside(const Shape& s, const Vec3& p) {
  if (s.kind == ShapeKind::box) return (p.cwiseAbs().array() <= s.size.array()).all();
  return p.norm() <= s.size.x();
}

// Volume and second moments by sampling a cube.
TEST(Shapes, VolumeAndInertiaAgreeWithSampling) {
  for (const Shape& s : {Shape{ShapeKind::sphere, {0.7, 0, 0}}, Shape{ShapeKind::box, {0.3, 0.5, 0.9}}}) {
    Random random(1);
    const int samples = 400000;
    int hits = 0;
    Vec3 squares = Vec3::Zero();
    for (int i = 0; i < samples; ++i) {
      const Vec3 p = random.vector(-1, 1);
      if (inside(s, p)) ++hits, squares += p.cwiseProduct(p);
    }
    EXPECT_NEAR(volume(s), 8.0 * hits / samples, 0.02);
    const Vec3 moment = inertia(s, 3.0), sampled = 3.0 / hits * (Vec3::Constant(squares.sum()) - squares);
    EXPECT_LT((moment - sampled).norm(), 0.01 * moment.norm());
  }
}

TEST(Shapes, DiscTurnsAboutItsAxis) {
  const Shape s{ShapeKind::disc, {0.4, 0, 0}};
  EXPECT_DOUBLE_EQ(inertia(s, 2).y(), 2 * 0.16 / 2);
  EXPECT_GT(inertia(s, 2).minCoeff(), 0);
  EXPECT_DOUBLE_EQ(volume(s), std::numbers::pi * 0.16);
}

TEST(Shapes, BoundsHoldTheTurnedShapeTightly) {
  Random random(2);
  for (int k = 0; k < 50; ++k) {
    const Quat q = random.turn();
    const Vec3 half = random.vector(0.1, 1);
    const Vec3 bound = bounding_half_extents({ShapeKind::box, half}, q);
    Vec3 reached = Vec3::Zero();
    for (int c = 0; c < 8; ++c) {
      const Vec3 corner = half.cwiseProduct(Vec3(c & 1 ? 1 : -1, c & 2 ? 1 : -1, c & 4 ? 1 : -1));
      reached = reached.cwiseMax((q * corner).cwiseAbs());
    }
    EXPECT_LT((reached - bound).norm(), 1e-12);
    EXPECT_NEAR(bounding_radius({ShapeKind::box, half}), half.norm(), 1e-15);

    const Vec3 flat = bounding_half_extents({ShapeKind::disc, {0.5, 0, 0}}, q);
    Vec3 rim = Vec3::Zero();
    for (int i = 0; i < 3600; ++i) {
      const double angle = i * std::numbers::pi / 1800;
      rim = rim.cwiseMax((q * Vec3(0.5 * std::cos(angle), 0, 0.5 * std::sin(angle))).cwiseAbs());
    }
    EXPECT_LT((rim - flat).norm(), 1e-5);
  }
}

TEST(Shapes, SmallestSizeAndPlanes) {
  EXPECT_DOUBLE_EQ(smallest_size({ShapeKind::sphere, {0.5, 0, 0}}), 1);
  EXPECT_DOUBLE_EQ(smallest_size({ShapeKind::box, {0.5, 0.2, 0.3}}), 0.4);
  const Shape plane{ShapeKind::plane, Vec3::Zero()};
  EXPECT_TRUE(std::isinf(bounding_radius(plane)));
  EXPECT_TRUE(std::isinf(smallest_size(plane)));
  EXPECT_TRUE(std::isinf(bounding_half_extents(plane, Quat::Identity()).x()));
  EXPECT_EQ(volume(plane), 0);
}

}  // namespace
}  // namespace unibody::shapes_test
