#include "collide/box_box.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "collide/bodies.hpp"

namespace unibody::box_box_test {
namespace {

using namespace samples;

Vec3 half(const Body& b) { return b.properties.shape.size; }
Mat3 axes(const Body& b) { return b.state.orientation.toRotationMatrix(); }

double extent(const Body& b, const Vec3& n) { return (axes(b).transpose() * n).cwiseAbs().dot(half(b)); }

// Separation of two boxes along a direction, in world axes.
double separation(const Body& a, const Body& b, const Vec3& n) {
  return std::abs(n.dot(a.state.position - b.state.position)) - extent(a, n) - extent(b, n);
}

// The largest over the 15 axes.
double separation(const Body& a, const Body& b) {
  double best = -HUGE_VAL;
  for (int i = 0; i < 3; ++i) {
    best = std::max({best, separation(a, b, axes(a).col(i)), separation(a, b, axes(b).col(i))});
    for (int j = 0; j < 3; ++j) {
      const Vec3 n = axes(a).col(i).cross(axes(b).col(j));
      if (n.norm() > 1e-3) best = std::max(best, separation(a, b, n.normalized()));
    }
  }
  return best;
}

Vec3 project(const Body& b, const Vec3& p) {
  const Vec3 local = axes(b).transpose() * (p - b.state.position);
  return b.state.position + axes(b) * local.cwiseMax(-half(b)).cwiseMin(half(b));
}

// Distance of two boxes by projecting to and fro.
double distance(const Body& a, const Body& b) {
  Vec3 p = project(a, b.state.position), q = p;
  for (int i = 0; i < 20000; ++i) q = project(b, p), p = project(a, q);
  return (p - q).norm();
}

double off_surface(const Body& b, const Vec3& p) {
  const Vec3 local = (axes(b).transpose() * (p - b.state.position)).cwiseAbs() - half(b);
  return local.maxCoeff() > 0 ? local.cwiseMax(0).norm() : -local.maxCoeff();
}

CollideSettings still(double margin) {
  CollideSettings s;
  s.margin = margin;
  return s;
}

struct Two {
  Body a, b;
};
Two random_two(Random& random, double reach) {
  return {box(0, random.vector(0.05, 0.3), random.vector(-0.1, 0.1), random.turn()),
          box(1, random.vector(0.05, 0.3), random.vector(-reach, reach), random.turn())};
}

double smallest(const Two& t) { return std::min(half(t.a).minCoeff(), half(t.b).minCoeff()); }

TEST(BoxBox, OverlappingBoxesArePushedOutAlongTheAxisOfLeastDepth) {
  Random random(1);
  int seen = 0;
  for (int k = 0; k < 5000; ++k) {
    const Two t = random_two(random, 0.4);
    const double depth = separation(t.a, t.b);
    if (depth > 0) continue;
    ++seen;
    const Pair p = collide_two(t.a, t.b, still(0.01));
    ASSERT_FALSE(p.points.empty());
    EXPECT_NEAR(p.normal.norm(), 1, 1e-12);
    EXPECT_GE(p.normal.dot(t.a.state.position - t.b.state.position), -1e-12);  // from b to a
    // within the bias in favour of faces
    const double along = separation(t.a, t.b, p.normal);
    EXPECT_GE(along, depth * 1.03 - 2e-3 * smallest(t)) << k;
    EXPECT_LE(along, depth + 1e-12);
    EXPECT_LE(p.smallest_gap(), 0);
    EXPECT_GE(p.smallest_gap(), along - 1e-12);  // no point is deeper than the boxes overlap
    // moved apart by the depth along the normal, they no longer overlap
    Body moved = t.a;
    moved.state.position += -along * p.normal;
    EXPECT_GE(separation(moved, t.b), -1e-12);
  }
  EXPECT_GT(seen, 1500);
}

TEST(BoxBox, SeparatedBoxesWithinTheMarginHaveOpenContacts) {
  Random random(2);
  int seen = 0;
  for (int k = 0; k < 3000 && seen < 400; ++k) {
    const Two t = random_two(random, 0.5);
    const double s = separation(t.a, t.b);
    if (s <= 1e-4 || s > 0.1) continue;
    ++seen;
    const double d = distance(t.a, t.b);
    const Pair p = collide_two(t.a, t.b, still(0.1));
    if (d <= 0.1) {
      ASSERT_FALSE(p.points.empty()) << k;
    }
    if (p.points.empty()) continue;
    EXPECT_GT(separation(t.a, t.b, p.normal), 0);         // the normal separates
    EXPECT_LE(separation(t.a, t.b, p.normal), d + 1e-6);  // and claims no more than there is
    EXPECT_GE(p.smallest_gap(), separation(t.a, t.b, p.normal) - 1e-12);
    for (const auto& point : p.points) EXPECT_LE(point.gap, 0.1);
  }
  EXPECT_GE(seen, 300);
}

// Falling straight down along the normal, two boxes are met by a contact before they overlap, and its gap tells when.
TEST(BoxBox, ContactIsFoundBeforeTheBoxesOverlap) {
  Random random(3);
  int seen = 0;
  for (int k = 0; k < 1000; ++k) {
    Two t = random_two(random, 0.4);
    const double s = separation(t.a, t.b);
    if (s > -0.02 || s < -0.1) continue;
    const Vec3 n = collide_two(t.a, t.b, still(0)).normal;
    t.a.state.position += (0.004 - separation(t.a, t.b, n)) * n;  // open by 4 mm along n
    if (separation(t.a, t.b, n) < separation(t.a, t.b) - 1e-4) continue;
    ++seen;
    const Pair p = collide_two(t.a, t.b, still(0.005));
    ASSERT_FALSE(p.points.empty()) << k;
    EXPECT_GT(p.smallest_gap(), 0);
    EXPECT_LE(p.smallest_gap(), 0.0052);
  }
  EXPECT_GT(seen, 50);
}

TEST(BoxBox, FacePointsLieHalfWayBetweenTheSurfaces) {
  Random random(4);
  int faces = 0;
  for (int k = 0; k < 2000; ++k) {
    const Two t = random_two(random, 0.45);
    const Pair p = collide_two(t.a, t.b, still(0.05));
    for (const auto& point : p.points) {
      if (point.feature >= 1u << 13) continue;  // an edge's or a corner's
      // an edge axis gives its gap to clipped points: only the incident surface is met then
      const bool face = (axes(t.a).transpose() * p.normal).cwiseAbs().maxCoeff() > 1 - 1e-12 ||
                        (axes(t.b).transpose() * p.normal).cwiseAbs().maxCoeff() > 1 - 1e-12;
      if (!face) continue;
      ++faces;
      EXPECT_LT(off_surface(t.a, point.position + 0.5 * point.gap * p.normal), 1e-12);
      EXPECT_LT(off_surface(t.b, point.position - 0.5 * point.gap * p.normal), 1e-12);
    }
  }
  EXPECT_GT(faces, 1000);
}

TEST(BoxBox, FeaturesAreUniqueAndAscendingAndAtMostEight) {
  Random random(5);
  std::size_t most = 0;
  for (int k = 0; k < 3000; ++k) {
    Two t = random_two(random, 0.3);
    if (k % 3 == 0) t.b.state.orientation = t.a.state.orientation;  // aligned: all ties
    if (k % 3 == 1) t.b.state.orientation = t.a.state.orientation * Quat(Eigen::AngleAxisd(random(-1, 1), Vec3::Unit(k % 2)));
    const Pair p = collide_two(t.a, t.b, still(0.2));
    most = std::max(most, p.points.size());
    std::set<std::uint32_t> features;
    for (std::size_t i = 0; i < p.points.size(); ++i) {
      features.insert(p.points[i].feature);
      if (i > 0) {
        EXPECT_LT(p.points[i - 1].feature, p.points[i].feature);
      }
      EXPECT_TRUE(p.points[i].position.allFinite());
    }
    EXPECT_EQ(features.size(), p.points.size());
  }
  EXPECT_EQ(most, 8u);
}

TEST(BoxBox, StackedBoxesTouchAtFourCorners) {
  const Vec3 size(0.06, 0.06, 0.075);
  for (const double gap : {-0.01, 0.0, 0.001}) {
    const Pair p = collide_two(box(0, size, Vec3(1, 2, 0.15 + gap)), box(1, size, Vec3(1.01, 2.02, 0)), still(0.002));
    ASSERT_EQ(p.points.size(), 4u);
    EXPECT_LT((p.normal - Vec3::UnitZ()).norm(), 1e-14);
    for (const auto& point : p.points) {
      EXPECT_NEAR(point.gap, gap, 1e-14);
      EXPECT_NEAR(point.position.z(), 0.075 + gap / 2, 1e-14);
    }
  }
  // turned by 45 degrees the overlap has eight corners
  const Quat turn(Eigen::AngleAxisd(std::acos(-1.0) / 4, Vec3::UnitZ()));
  EXPECT_EQ(collide_two(box(0, size, Vec3(0, 0, 0.15)), box(1, size, Vec3::Zero(), turn), still(0.002)).points.size(), 8u);
}

// A box almost flat over another, turned a little about two axes: more than one point, or it would spin about it.
TEST(BoxBox, EdgeAxisNeverLeavesAPivot) {
  Random random(6);
  const Vec3 size(0.06, 0.06, 0.075);
  int edges = 0;
  for (int k = 0; k < 3000; ++k) {
    const Quat tilt(Eigen::AngleAxisd(random(0.02, 0.1), Vec3(random(-1, 1), random(-1, 1), 0).normalized()));
    const Body a = box(0, size, Vec3(random(-0.05, 0.05), random(-0.05, 0.05), 0.15 + random(0.0, 0.03)), tilt);
    const Body b = box(1, size, Vec3::Zero());
    const Pair p = collide_two(a, b, still(0.06));
    bool edge = false;
    for (const auto& point : p.points) edge = edge || (point.feature >> 13) == 1;
    if (!edge) continue;
    ++edges;
    EXPECT_GE(p.points.size(), 3u) << k;
    for (const auto& point : p.points) EXPECT_GE(point.gap, separation(a, b, p.normal) - 1e-12);
  }
  EXPECT_GT(edges, 20);
}

TEST(BoxBox, CrossedEdgesMeetInTheMiddle) {
  const Quat a(Eigen::AngleAxisd(std::acos(-1.0) / 4, Vec3::UnitX())), b(Eigen::AngleAxisd(std::acos(-1.0) / 4, Vec3::UnitY()));
  const double r = 0.1 * std::sqrt(2.0);
  const Pair p = collide_two(box(0, Vec3(0.1, 0.1, 0.1), Vec3(0, 0, 2 * r - 0.001), a),
                             box(1, Vec3(0.1, 0.1, 0.1), Vec3::Zero(), b), still(0.002));
  ASSERT_FALSE(p.points.empty());
  EXPECT_LT((p.normal - Vec3::UnitZ()).norm(), 1e-12);
  EXPECT_NEAR(p.smallest_gap(), -0.001, 1e-12);
  bool middle = false;
  for (const auto& point : p.points) middle = middle || (point.position - Vec3(0, 0, r - 0.0005)).norm() < 1e-12;
  EXPECT_TRUE(middle);
}

// Upright boxes turned about their common axis, some edges of which pass each other: contacts close at most what the boxes are
// apart, and leave of it no more than edges leave that are rounded by 0.05 of the smallest half edge (0.3 of that radius). Where
// edges overlap, the way out between two faces is up to sqrt 2 as long as that through one of them.
TEST(BoxBox, EdgesAlongEachOtherAreApartByWhatTheBoxesAre) {
  Random random(41);
  const double margin = 0.01;
  int edges = 0;
  for (int k = 0; k < 40000; ++k) {
    const Quat frame = random.turn();
    const auto turned = [&] { return frame * Quat(Eigen::AngleAxisd(random.vector(-3, 3).x(), Vec3::UnitZ())); };
    const Two t{box(0, random.vector(0.05, 0.3), Vec3::Zero(), turned()),
                box(1, random.vector(0.05, 0.3), frame * random.vector(-0.6, 0.6).cwiseProduct(Vec3(1, 1, 0.05)), turned())};
    const double axis = separation(t.a, t.b);
    if (axis > margin) continue;
    const double apart = axis > 0 ? distance(t.a, t.b) : axis;
    if (std::abs(apart) > margin) continue;
    const Pair p = collide_two(t.a, t.b, still(margin));
    const double least = 0.05 * 0.3 * smallest(t) + 1e-3 * smallest(t);
    double gap = margin;
    for (const auto& point : p.points) gap = std::min(gap, point.gap);
    EXPECT_LE(gap, std::max(apart, axis) + 1e-9) << k;
    EXPECT_GE(gap, (apart < 0 ? std::sqrt(2.0) * apart : apart) - least) << k;
    bool on_face = false;
    for (int i = 0; i < 3; ++i)
      on_face =
          on_face || std::abs(axes(t.a).col(i).dot(p.normal)) > 1 - 1e-9 || std::abs(axes(t.b).col(i).dot(p.normal)) > 1 - 1e-9;
    edges += !p.points.empty() && !on_face;
  }
  EXPECT_GT(edges, 15);
}

TEST(BoxBox, DegeneratePairsAreFinite) {
  const Quat turn(Eigen::AngleAxisd(1e-9, Vec3(1, 1, 1).normalized()));
  const Vec3 size(0.1, 0.1, 0.1);
  const std::vector<Two> pairs{
      {box(0, size, Vec3::Zero()), box(1, size, Vec3(0.2, 0.2, 0.2))},            // corner on corner
      {box(0, size, Vec3::Zero()), box(1, size, Vec3(0.2, 0.2, 0.0))},            // edge on edge, parallel
      {box(0, size, Vec3::Zero()), box(1, size, Vec3(0.1, 0.1, 0.1))},            // half overlapping
      {box(0, size, Vec3::Zero()), box(1, size, Vec3(0.2, 0, 0), turn)},          // almost parallel
      {box(0, size, Vec3::Zero()), box(1, size, Vec3::Zero(), turn)},             // on top of each other
      {box(0, Vec3(10, 10, 1e-6), Vec3::Zero()), box(1, size, Vec3(3, 2, 0.1))},  // a sheet
      {box(0, Vec3(100, 100, 1), Vec3(0, 0, -1)), box(1, size * 1e-3, Vec3(50, 50, 1e-4))},
  };
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    const Pair p = collide_two(pairs[k].a, pairs[k].b, still(0.002));
    ASSERT_FALSE(p.points.empty()) << k;
    EXPECT_NEAR(p.normal.norm(), 1, 1e-12) << k;
    for (const auto& point : p.points) EXPECT_TRUE(point.position.allFinite() && std::isfinite(point.gap)) << k;
  }
}

}  // namespace
}  // namespace unibody::box_box_test
