// Whether a point on a straight way passes through a mesh or into a solid, beside closed forms.
#include "collide/passage.hpp"

#include <gtest/gtest.h>

#include <random>

#include "world/hull.hpp"
#include "world/mesh_shape.hpp"

namespace unibody::passage_test {

namespace {

class Random {
 public:
  Vec3 point(double extent) {
    std::uniform_real_distribution<double> x(-extent, extent);
    return {x(engine_), x(engine_), x(engine_)};
  }

 private:
  std::mt19937 engine_{7};
};

// Where a way enters a box of half edges `half` about the origin, by its three slabs; more than 1: nowhere.
double share_by_slabs(const Vec3& half, const Vec3& from, const Vec3& to, int& axis) {
  double enters = 0, leaves = 1;
  for (int k = 0; k < 3; ++k) {
    const double way = to[k] - from[k], side = way > 0 ? -half[k] : half[k];
    const double in = (side - from[k]) / way, out = (-side - from[k]) / way;
    if (in > enters) enters = in, axis = k;
    leaves = std::min(leaves, out);
  }
  return enters <= leaves ? enters : 2;
}

double share_by_sphere(double radius, const Vec3& from, const Vec3& to) {
  const Vec3 way = to - from;
  const double a = way.squaredNorm(), b = from.dot(way), c = from.squaredNorm() - radius * radius, d = b * b - a * c;
  return d >= 0 && b < 0 ? (-b - std::sqrt(d)) / a : 2;
}

ConvexBody solid(const Shape& shape) { return convex_body(shape, Mat3::Identity(), Vec3::Zero()); }

}  // namespace

TEST(Passage, IntoABoxAndASphereIsWhereTheClosedFormSays) {
  const Vec3 half(0.5, 0.3, 0.02);
  const ConvexBody box = solid({ShapeKind::box, half}), ball = solid({ShapeKind::sphere, Vec3::Constant(0.4)});
  Random random;
  int entered = 0, missed = 0;
  for (int k = 0; k < 20000; ++k) {
    const Vec3 from = random.point(1), to = random.point(1);
    int axis = 0;
    if ((from.cwiseAbs().array() > half.array()).any()) {
      const double share = share_by_slabs(half, from, to, axis);
      const Passage found = passage_into(box, from, to);
      ASSERT_EQ(found.exists(), share <= 1) << k;
      share <= 1 ? ++entered : ++missed;
      if (share <= 1) {
        EXPECT_NEAR(found.share, share, 1e-5) << k;
        const double side = from[axis] > 0 ? 1 : -1;
        EXPECT_NEAR(found.height_before, std::abs(from[axis]) - half[axis], 1e-6) << k;
        EXPECT_NEAR(found.height, side * to[axis] - half[axis], 1e-6) << k;
        EXPECT_NEAR(found.normal[axis], side, 1e-6) << k;
      }
    }
    if (from.norm() <= 0.4) continue;
    const double share = share_by_sphere(0.4, from, to);
    const Passage found = passage_into(ball, from, to);
    ASSERT_EQ(found.exists(), share <= 1) << k;
    if (share <= 1) {
      EXPECT_LT(std::abs((from + found.share * (to - from)).norm() - 0.4), 1e-5) << k;
    }
  }
  EXPECT_GT(entered, 1000);
  EXPECT_GT(missed, 1000);
}

TEST(Passage, APointThatStartsWithinDoesNotComeIn) {
  const ConvexBody box = solid({ShapeKind::box, Vec3(0.5, 0.3, 0.2)});
  EXPECT_FALSE(passage_into(box, Vec3(0.4, 0, 0), Vec3(2, 0, 0)).exists());
  EXPECT_FALSE(passage_into(box, Vec3(0.4, 0, 0), Vec3(0.1, 0.1, 0)).exists());
}

// A cube of twelve triangles turned outwards: what goes in is seen, what comes out only if it has two sides.
TEST(Passage, ThroughAMeshIsWhereTheClosedFormSays) {
  std::vector<Vec3> nodes;
  for (int k = 0; k < 8; ++k) nodes.emplace_back(k & 1 ? 0.5 : -0.5, k & 2 ? 0.5 : -0.5, k & 4 ? 0.5 : -0.5);
  const std::vector<std::array<std::int32_t, 3>> triangles{{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                                                           {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  const MeshSurface outside = make_mesh_shape(nodes, triangles);
  MeshSurface both = outside;
  touch_from_both(both);
  const Vec3 half = Vec3::Constant(0.5);
  Random random;
  int in = 0, out = 0;
  for (int k = 0; k < 20000; ++k) {
    const Vec3 from = random.point(1), to = random.point(1);
    int axis = 0;
    const bool starts_within = (from.cwiseAbs().array() < 0.5).all();
    // The way of a point that leaves the cube, seen from its end, enters the cube.
    const double share = starts_within ? 1 - share_by_slabs(half, to, from, axis) : share_by_slabs(half, from, to, axis);
    const bool passes = starts_within ? (to.cwiseAbs().array() > 0.5).any() : share <= 1;
    const Passage one = passage_through(outside, from, to), two = passage_through(both, from, to);
    ASSERT_EQ(one.exists(), passes && !starts_within) << k;
    ASSERT_EQ(two.exists(), passes) << k;
    if (passes) {
      EXPECT_NEAR(two.share, share, 1e-12) << k;
      EXPECT_GT(two.height_before, 0) << k;
    }
    in += passes && !starts_within, out += passes && starts_within;
  }
  EXPECT_GT(in, 500);
  EXPECT_GT(out, 500);
}

// Through edges and nodes, where rounding may put a point beside all triangles.
TEST(Passage, NothingSlipsThroughBetweenTriangles) {
  std::vector<Vec3> nodes{Vec3(0.1, 0.2, 0)};
  std::vector<std::array<std::int32_t, 3>> triangles;
  for (int k = 0; k < 7; ++k) nodes.emplace_back(std::cos(0.9 * k), std::sin(0.9 * k), 0.05 * std::sin(2.0 * k));
  for (std::int32_t k = 0; k < 7; ++k) triangles.push_back({0, 1 + k, 1 + (k + 1) % 7});
  const MeshSurface fan = make_mesh_shape(nodes, triangles, 0, true);
  Random random;
  for (int k = 0; k < 7000; ++k) {
    const Vec3 on_edge = nodes[0] + (k % 8) / 10.0 * (nodes[static_cast<std::size_t>(1 + k % 7)] - nodes[0]);
    const Vec3 down = Vec3(0, 0, -1) + 0.2 * random.point(1);
    EXPECT_TRUE(passage_through(fan, on_edge - down, on_edge + down).exists()) << k;
  }
}

// What is held back ends over all surfaces, whatever it comes to.
TEST(Passage, WhatIsHeldBackEndsOutside) {
  const Vec3 half(0.5, 0.3, 0.02);
  const ConvexBody box = solid({ShapeKind::box, half});
  Random random;
  for (int k = 0; k < 5000; ++k) {
    const Vec3 from = random.point(1), to = random.point(1);
    if (!(from.cwiseAbs().array() > half.array() + 0.01).any()) continue;
    const Vec3 place = held_back(from, to, 0.01, [&](const Vec3& a, const Vec3& b) { return passage_into(box, a, b); });
    EXPECT_TRUE((place.cwiseAbs().array() > half.array()).any()) << k;
    if (!passage_into(box, from, to).exists()) {
      EXPECT_EQ(place, to) << k;
    }
  }
}

}  // namespace unibody::passage_test
