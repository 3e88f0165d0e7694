// Closest points against 113 bits, on shapes of every kind from plump to none.
#include "collide/triangle_distance.hpp"

#include <gtest/gtest.h>

#include "collide/bodies.hpp"
#include "collide/reference_distance.hpp"

namespace unibody::triangle_distance_test {
namespace {

using namespace samples;

// A corner of the unit cube or a random point in it, so that parallel, coincident and degenerate features are frequent.
Vec3 random_node(Random& random) {
  Vec3 v = random.vector(-1, 1);
  if (random(0, 1) < 0.6) v = v.array().round();
  return v;
}

// One of many random shapes: plump, with nodes that nearly coincide, flat up to the last bits; anywhere, of any size.
template <std::size_t n>
std::array<Vec3, n> random_nodes(Random& random, double& scale) {
  std::array<Vec3, n> nodes;
  for (Vec3& v : nodes) v = random_node(random);
  if (random(0, 1) < 0.3) {  // draw one towards another, or towards the line through two
    const auto i = static_cast<std::size_t>(random(0, n)), j = static_cast<std::size_t>(random(0, n)),
               k = static_cast<std::size_t>(random(0, n));
    nodes[i] = nodes[j] + random(-1, 2) * (nodes[k] - nodes[j]) + random_node(random) * std::pow(10, random(-17, -1));
  }
  if (random(0, 1) < 0.2)
    for (Vec3& v : nodes) v.z() = 0;
  const double size = std::pow(10, random(-20, 20));
  const Vec3 offset = random(0, 1) < 0.5 ? Vec3(Vec3::Zero()) : random.vector(-100, 100);
  for (Vec3& v : nodes) v = size * (v + offset);
  scale = size * (2 + offset.norm());
  return nodes;
}

TEST(TriangleDistance, PointAndTriangleAsIn113Bits) {
  Random random(1);
  double worst = 0;
  std::array<int, 8> features{};
  for (int i = 0; i < 200000; ++i) {
    double scale = 0;
    const auto [p, a, b, c] = random_nodes<4>(random, scale);
    const TrianglePoint near = closest_on_triangle(p, a, b, c);
    const double reference = root(reference_distance(wide<Quad>(p), wide<Quad>(a), wide<Quad>(b), wide<Quad>(c)));
    ++features[near.feature()];
    worst = std::max(worst, std::abs(near.distance - reference) / scale);
    ASSERT_NEAR(near.distance, reference, 4e-15 * scale) << i;
    ASSERT_GE(near.weights.minCoeff(), 0) << i;
    ASSERT_NEAR(near.weights.sum(), 1, 1e-15) << i;
    const Vec3 combined = near.weights[0] * a + near.weights[1] * b + near.weights[2] * c;
    ASSERT_LT((combined - near.point).norm(), 2e-15 * scale) << i;
    ASSERT_NEAR((near.point - p).norm(), near.distance, 1e-15 * scale) << i;
  }
  EXPECT_EQ(features[0], 0);
  for (std::size_t f = 1; f < 8; ++f) EXPECT_GT(features[f], 5000) << f;
  std::cout << "point and triangle: largest error " << worst << " of the coordinates\n";
}

TEST(TriangleDistance, SegmentsAsIn113Bits) {
  Random random(2);
  double worst = 0;
  int inner = 0;
  for (int i = 0; i < 200000; ++i) {
    double scale = 0;
    const auto [p0, p1, q0, q1] = random_nodes<4>(random, scale);
    const SegmentPoints near = closest_of_segments(p0, p1, q0, q1);
    const double reference = root(reference_distance_of_segments(wide<Quad>(p0), wide<Quad>(p1), wide<Quad>(q0), wide<Quad>(q1)));
    worst = std::max(worst, std::abs(near.distance - reference) / scale);
    ASSERT_NEAR(near.distance, reference, 4e-15 * scale) << i;
    ASSERT_TRUE(near.s >= 0 && near.s <= 1 && near.t >= 0 && near.t <= 1) << i;
    ASSERT_LT((p0 + near.s * (p1 - p0) - near.first).norm(), 2e-15 * scale) << i;
    ASSERT_LT((q0 + near.t * (q1 - q0) - near.second).norm(), 2e-15 * scale) << i;
    ASSERT_NEAR((near.first - near.second).norm(), near.distance, 1e-15 * scale) << i;
    inner += near.s > 0 && near.s < 1 && near.t > 0 && near.t < 1;
  }
  EXPECT_GT(inner, 20000);
  std::cout << "two segments: largest error " << worst << " of the coordinates\n";
}

// No formula at all: no other pair of points is closer.
TEST(TriangleDistance, NoOtherPointIsCloser) {
  Random random(3);
  for (int i = 0; i < 300; ++i) {
    double scale = 0;
    const auto [p, a, b, c] = random_nodes<4>(random, scale);
    const double on_triangle = closest_on_triangle(p, a, b, c).distance, of_segments = closest_of_segments(p, a, b, c).distance;
    for (int j = 0; j <= 20; ++j)
      for (int k = 0; k <= 20; ++k) {
        const double s = j / 20.0, t = k / 20.0;
        ASSERT_GE(((1 - s) * p + s * a - (1 - t) * b - t * c).norm(), of_segments - 4e-15 * scale);
        if (s + t > 1) continue;
        ASSERT_GE((p - (1 - s - t) * a - s * b - t * c).norm(), on_triangle - 4e-15 * scale);
      }
  }
}

TEST(TriangleDistance, FeaturesByHand) {
  const Vec3 a(0, 0, 0), b(1, 0, 0), c(0, 1, 0);
  const auto feature = [&](double x, double y, double z) { return closest_on_triangle(Vec3(x, y, z), a, b, c).feature(); };
  EXPECT_EQ(feature(0.2, 0.2, 3), 7u);
  EXPECT_EQ(feature(0.2, 0.2, 0), 7u);
  EXPECT_EQ(feature(-1, -1, 1), 1u);
  EXPECT_EQ(feature(2, 0, 1), 2u);
  EXPECT_EQ(feature(0, 2, -1), 4u);
  EXPECT_EQ(feature(0.5, -1, 1), 3u);
  EXPECT_EQ(feature(1, 1, 1), 6u);
  EXPECT_EQ(feature(-1, 0.5, 1), 5u);
  EXPECT_EQ(closest_on_triangle(Vec3(3, 4, 0), a, a, a).distance, 5);
  EXPECT_EQ(closest_of_segments(a, a, Vec3(3, 4, 0), Vec3(3, 4, 0)).distance, 5);
  EXPECT_EQ(closest_of_segments(a, b, Vec3(0.25, 2, 0), Vec3(0.5, 2, 0)).distance, 2);
}

}  // namespace
}  // namespace unibody::triangle_distance_test
