// Contacts of spheres and boxes with triangles against distances in wider numbers, feature by feature.
#include "collide/triangle_contacts.hpp"

#include <gtest/gtest.h>

#include <chrono>

#include "collide/bodies.hpp"
#include "collide/reference_distance.hpp"
#include "collide/triangle_crossing.hpp"
#include "scene/grid_mesh.hpp"

namespace unibody::triangle_contacts_test {
namespace {

using namespace samples;

struct Block {
  Vec3 centre, half;
  Mat3 rotation;

  Vec3 corner(int i) const {
    return centre + rotation * Vec3(i & 1 ? half[0] : -half[0], i & 2 ? half[1] : -half[1], i & 4 ? half[2] : -half[2]);
  }
  // Pairs of corners that differ in one axis.
  template <class Use>
  void for_each_edge(Use use) const {
    for (int i = 0; i < 8; ++i)
      for (int bit = 1; bit < 8; bit *= 2)
        if (!(i & bit)) use(corner(i), corner(i | bit));
  }
  Vec3 local(const Vec3& x) const { return rotation.transpose() * (x - centre); }
};

// In world axes, by corners, edges and faces cut into triangles; 0 where they overlap.
double reference_distance_of(const Block& b, const TriangleNodes& n) {
  const auto w = [](const Vec3& x) { return wide<Long>(x); };
  for (const Vec3& x : n)
    if (((b.local(x).cwiseAbs() - b.half).array() <= 0).all()) return 0;
  Long best = HUGE_VALL;
  bool crossed = false;
  for (int i = 0; i < 8; ++i) best = std::min(best, reference_distance(w(b.corner(i)), w(n[0]), w(n[1]), w(n[2])));
  b.for_each_edge([&](const Vec3& p, const Vec3& q) {
    crossed = crossed || edge_crosses_face(p, q, n[0], n[1], n[2]);
    for (std::size_t i = 0; i < 3; ++i)
      best = std::min(best, reference_distance_of_segments(w(p), w(q), w(n[i]), w(n[(i + 1) % 3])));
  });
  for (int bit = 1; bit < 8; bit *= 2)
    for (const int from : {0, bit}) {
      const int u = bit == 1 ? 2 : 1, v = bit == 4 ? 2 : 4;
      const Vec3 c[4] = {b.corner(from), b.corner(from | u), b.corner(from | u | v), b.corner(from | v)};
      for (const int k : {1, 2})
        for (std::size_t i = 0; i < 3; ++i) {
          best = std::min(best, reference_distance(w(n[i]), w(c[0]), w(c[k]), w(c[k + 1])));
          crossed = crossed || edge_crosses_face(n[i], n[(i + 1) % 3], c[0], c[k], c[k + 1]);
        }
    }
  return crossed ? 0 : root(best);
}

Block random_block(Random& random) {
  Block b{random.vector(-0.3, 0.3), random.vector(0.05, 0.5), random.turn().toRotationMatrix()};
  if (random(0, 1) < 0.4) b.rotation = Mat3::Identity();
  return b;
}

TriangleNodes random_triangle(Random& random) {
  const double size = std::pow(10, random(-1.5, 0.5));
  const Vec3 at = random.vector(-0.8, 0.8);
  TriangleNodes n;
  for (Vec3& x : n) x = at + size * random.vector(-1, 1);
  if (random(0, 1) < 0.3) n[1].z() = n[2].z() = n[0].z();  // parallel to the faces of a box that isn't turned
  if (random(0, 1) < 0.2) n[1].x() = n[2].x() = n[0].x();  // perhaps without area
  return n;
}

// What holds for every point: it lies half way between a point of the triangle and one of the box, along the normal.
void expect_consistent(const TriangleContacts& contacts, const Block& b, const TriangleNodes& n) {
  for (int i = 0; i < contacts.count; ++i) {
    const TriangleContact& c = contacts.points[static_cast<std::size_t>(i)];
    if (i > 0) {
      ASSERT_GT(c.feature, contacts.points[static_cast<std::size_t>(i - 1)].feature);
    }
    ASSERT_NEAR(c.normal.norm(), 1, 1e-14);
    ASSERT_GE(c.weights.minCoeff(), 0);
    ASSERT_NEAR(c.weights.sum(), 1, 1e-14);
    const Vec3 on_triangle = c.weights[0] * n[0] + c.weights[1] * n[1] + c.weights[2] * n[2];
    ASSERT_LT((c.position - 0.5 * c.gap * c.normal - on_triangle).norm(), 1e-13);
    // on the surface: within no face by more than rounding, and on one of them
    const Vec3 beyond = b.local(c.position + 0.5 * c.gap * c.normal).cwiseAbs() - b.half;
    ASSERT_NEAR(beyond.maxCoeff(), 0, 1e-12) << c.feature;
  }
}

double smallest_gap(const TriangleContacts& contacts) {
  double smallest = HUGE_VAL;
  for (int i = 0; i < contacts.count; ++i) smallest = std::min(smallest, contacts.points[static_cast<std::size_t>(i)].gap);
  return smallest;
}

TEST(TriangleContacts, SmallestGapOfABoxThatIsApartIsTheDistance) {
  Random random(1);
  int apart = 0, points = 0;
  double worst = 0;
  for (int k = 0; k < 30000; ++k) {
    const Block b = random_block(random);
    const TriangleNodes n = random_triangle(random);
    const double distance = reference_distance_of(b, n);
    if (distance < 1e-6) continue;
    ++apart;
    TriangleContacts contacts;
    box_triangle(b.centre, b.rotation, b.half, n, {distance * 1.5, 0.1}, contacts);
    expect_consistent(contacts, b, n);
    ASSERT_NEAR(smallest_gap(contacts), distance, 1e-13) << k;
    worst = std::max(worst, std::abs(smallest_gap(contacts) - distance));
    points += contacts.count;
    box_triangle(b.centre, b.rotation, b.half, n, {distance * 0.999, 0.1}, contacts);
    ASSERT_EQ(contacts.count, 0) << k;
  }
  EXPECT_GT(apart, 10000);
  std::cout << apart << " pairs apart: largest error of the smallest gap " << worst << " m; " << 1.0 * points / apart
            << " points each\n";
}

// From apart into overlap by a small depth along the direction of the closest points: something is in contact, and nothing is
// deeper than they were pushed.
TEST(TriangleContacts, ShallowOverlapIsSeenAndNotOverstated) {
  Random random(2);
  int pushed = 0;
  for (int k = 0; k < 30000; ++k) {
    Block b = random_block(random);
    const TriangleNodes n = random_triangle(random);
    const double distance = reference_distance_of(b, n);
    if (distance < 1e-3 || distance > 1) continue;
    TriangleContacts contacts;
    box_triangle(b.centre, b.rotation, b.half, n, {2, 0.1}, contacts);
    const TriangleContact* nearest = &contacts.points[0];
    for (int i = 1; i < contacts.count; ++i)
      if (contacts.points[static_cast<std::size_t>(i)].gap < nearest->gap)
        nearest = &contacts.points[static_cast<std::size_t>(i)];
    const double depth = 1e-4;
    b.centre -= (nearest->gap + depth) * nearest->normal;
    TriangleContacts overlap;
    box_triangle(b.centre, b.rotation, b.half, n, {0, 0.1}, overlap);
    ++pushed;
    expect_consistent(overlap, b, n);
    ASSERT_GT(overlap.count, 0) << k;
    ASSERT_GE(smallest_gap(overlap), -depth * (1 + 1e-6)) << k << " " << nearest->feature;
  }
  EXPECT_GT(pushed, 10000);
}

// A box on a grid: all points at the height of the box, all four corners among them, whatever the sense of the triangles.
TEST(TriangleContacts, BoxThatLiesFlatOnAGrid) {
  for (const double height : {1e-3, 0.0, -1e-3})
    for (const bool turned : {false, true}) {
      TriangleMesh mesh = grid_mesh({2, 2}, {9, 9});
      if (turned)
        for (auto& t : mesh.triangles) std::swap(t[0], t[1]);
      const Block b{Vec3(0.01, 0.02, 0.2 + height), Vec3(0.4, 0.3, 0.2), Mat3(Eigen::AngleAxisd(0.3, Vec3::UnitZ()))};
      int corners = 0, nodes = 0, edges = 0;
      for (const auto& t : mesh.triangles) {
        const auto node = [&](std::size_t k) { return mesh.nodes[static_cast<std::size_t>(t[k])]; };
        const TriangleNodes n{node(0), node(1), node(2)};
        TriangleContacts contacts;
        box_triangle(b.centre, b.rotation, b.half, n, {2e-3, 0.05}, contacts);
        expect_consistent(contacts, b, n);
        for (int i = 0; i < contacts.count; ++i) {
          const TriangleContact& c = contacts.points[static_cast<std::size_t>(i)];
          EXPECT_NEAR(c.gap, height, 1e-15);
          EXPECT_LT((c.normal - Vec3::UnitZ()).norm(), 1e-12) << c.feature;
          (c.feature < 8 ? corners : c.feature < 11 ? nodes : edges) += 1;
        }
      }
      EXPECT_EQ(corners, 4);
      EXPECT_GT(nodes, 20);  // once for each triangle of a node
      EXPECT_GT(edges, 10);
    }
}

TEST(TriangleContacts, CostOfABox) {
  Random random(4);
  std::vector<std::pair<Block, TriangleNodes>> pairs;
  for (int k = 0; k < 20000; ++k) pairs.emplace_back(random_block(random), random_triangle(random));
  int points = 0;
  const auto start = std::chrono::steady_clock::now();
  for (const auto& [b, n] : pairs) {
    TriangleContacts contacts;
    box_triangle(b.centre, b.rotation, b.half, n, {0.02, 0.05}, contacts);
    points += contacts.count;
  }
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  std::cout << "box and triangle: " << seconds / 20000 * 1e9 << " ns; " << points / 20000.0 << " points\n";
}

}  // namespace
}  // namespace unibody::triangle_contacts_test
