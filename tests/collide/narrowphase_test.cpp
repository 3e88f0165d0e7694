// Spheres, discs and planes, and what holds for all pairs.
#include "collide/narrowphase.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "collide/bodies.hpp"

namespace unibody::narrowphase_test {
namespace {

using namespace samples;

CollideSettings still(double margin) {
  CollideSettings s;
  s.margin = margin;
  return s;
}

Body random_body(Id id, Random& random, double side) {
  const Vec3 at = random.vector(-side, side);
  Body b = random(0, 1) < 0.5 ? sphere(id, random(0.05, 0.4), at) : box(id, random.vector(0.05, 0.4), at, random.turn());
  b.state.velocity = random.vector(-6, 6);
  b.state.angular_velocity = random.vector(-2, 2);
  return b;
}

TEST(NarrowPhase, SpheresTouchAlongTheirCentres) {
  Random random(1);
  for (int k = 0; k < 200; ++k) {
    const Body a = sphere(0, random(0.1, 1), random.vector(-1, 1)), b = sphere(1, random(0.1, 1), random.vector(-1, 1));
    const double ra = a.properties.shape.size.x(), rb = b.properties.shape.size.x();
    const Vec3 between = a.state.position - b.state.position;
    const double gap = between.norm() - ra - rb;
    const Pair p = collide_two(a, b, still(0.2));
    ASSERT_EQ(p.points.size(), gap <= 0.2 ? 1u : 0u);
    if (p.points.empty()) continue;
    EXPECT_NEAR(p.points[0].gap, gap, 1e-14);
    EXPECT_LT((p.normal - between.normalized()).norm(), 1e-14);
    // half way: each surface is gap / 2 from the point
    EXPECT_NEAR((p.points[0].position - a.state.position).norm(), std::abs(ra + gap / 2), 1e-13);
    EXPECT_NEAR((p.points[0].position - b.state.position).norm(), std::abs(rb + gap / 2), 1e-13);
    // the gap's gradient is the normal
    Body moved = a;
    const Vec3 direction = random.vector(-1, 1);
    moved.state.position += 1e-6 * direction;
    const Pair q = collide_two(moved, b, still(0.3));
    EXPECT_NEAR((q.points.at(0).gap - gap) / 1e-6, p.normal.dot(direction), 1e-4);
  }
}

TEST(NarrowPhase, CoincidentCentresGiveAFiniteNormalThatIsAlwaysTheSame) {
  const Pair p = collide_two(sphere(0, 0.5, Vec3::Ones()), sphere(1, 0.25, Vec3::Ones()), still(0));
  ASSERT_EQ(p.points.size(), 1u);
  EXPECT_EQ(p.normal, Vec3::UnitZ());
  EXPECT_DOUBLE_EQ(p.points[0].gap, -0.75);
  const Pair q = collide_two(sphere(0, 0.5, Vec3::Zero()), box(1, Vec3(1, 2, 3), Vec3::Zero()), still(0));
  ASSERT_EQ(q.points.size(), 1u);
  EXPECT_EQ(q.normal, Vec3::UnitX());
  EXPECT_DOUBLE_EQ(q.points[0].gap, -1.5);
  const Pair r = collide_two(box(0, Vec3(1, 1, 1), Vec3::Zero()), box(1, Vec3(1, 1, 1), Vec3::Zero()), still(0));
  ASSERT_GE(r.points.size(), 1u);
  EXPECT_NEAR(r.normal.norm(), 1, 1e-14);
  EXPECT_NEAR(r.smallest_gap(), -2, 1e-14);
}

TEST(NarrowPhase, SphereOnBoxAgreesWithTheNearestPoint) {
  Random random(2);
  for (int k = 0; k < 500; ++k) {
    const Body b = box(0, random.vector(0.1, 0.5), random.vector(-1, 1), random.turn());
    const Body s = sphere(1, random(0.05, 0.3), b.state.position + random.vector(-0.7, 0.7));
    const Vec3 local = b.state.orientation.conjugate() * (s.state.position - b.state.position), half = b.properties.shape.size;
    const double r = s.properties.shape.size.x();
    const Vec3 beyond = (local.cwiseAbs() - half).cwiseMax(0);
    const double gap = (beyond.norm() > 0 ? beyond.norm() : (local.cwiseAbs() - half).maxCoeff()) - r;
    const Pair p = collide_two(b, s, still(0.1));
    ASSERT_EQ(p.points.size(), gap <= 0.1 ? 1u : 0u);
    if (p.points.empty()) continue;
    EXPECT_NEAR(p.points[0].gap, gap, 1e-12);
    // moving the sphere (body b of the pair) out along -normal opens the gap by as much
    Body out = s;
    out.state.position -= 1e-6 * p.normal;
    EXPECT_NEAR(collide_two(b, out, still(0.2)).points.at(0).gap, gap + 1e-6, 1e-9);
    EXPECT_NEAR((p.points[0].position - s.state.position - (r + gap / 2) * p.normal).norm(), 0, 1e-12);
  }
}

TEST(NarrowPhase, PlaneCarriesSphereAndBox) {
  const Vec3 up = Vec3(1, 2, 3).normalized();
  const Body ground = plane(5, Vec3(0.3, 0.2, 0.1), up);
  const Pair p = collide_two(sphere(1, 0.2, Vec3(0.3, 0.2, 0.1) + 0.19 * up), ground, still(0.01));
  ASSERT_EQ(p.points.size(), 1u);
  EXPECT_NEAR(p.points[0].gap, -0.01, 1e-15);
  EXPECT_LT((p.normal - up).norm(), 1e-15);

  const Body crate = box(7, Vec3(0.1, 0.2, 0.3), Vec3(0, 0, 0.299), Quat::Identity());
  const Pair q = collide_two(plane(5), crate, still(0.01));
  ASSERT_EQ(q.points.size(), 4u);
  EXPECT_EQ(q.normal, Vec3(-Vec3::UnitZ()));  // from b, the crate, to a, the plane
  for (const auto& point : q.points) {
    EXPECT_NEAR(point.gap, -0.001, 1e-15);
    EXPECT_NEAR(point.position.z(), -0.0005, 1e-15);
    EXPECT_NEAR(std::abs(point.position.x()), 0.1, 1e-15);
  }
}

TEST(NarrowPhase, APlaneKnowsNoBackSide) {
  for (const double depth : {0.0, 0.05, 0.3, 2.0}) {  // of the centre: a body that was pressed through is pushed back
    const Pair p = collide_two(sphere(1, 0.2, Vec3(0, 0, -depth)), plane(5), still(0.01));
    const Pair q = collide_two(box(1, Vec3(0.1, 0.1, 0.1), Vec3(0, 0, -depth)), plane(5), still(0.01));
    ASSERT_EQ(p.points.size(), 1u);
    ASSERT_EQ(q.points.size(), depth < 0.1 ? 4u : 8u);
    EXPECT_EQ(p.normal, Vec3(Vec3::UnitZ()));
    EXPECT_EQ(q.normal, Vec3(Vec3::UnitZ()));
    EXPECT_NEAR(p.points[0].gap, -depth - 0.2, 1e-15);
    EXPECT_NEAR(q.points[0].gap, -depth - 0.1, 1e-15);
  }
}

TEST(NarrowPhase, MarginFollowsTheFasterBodyAndTheSpin) {
  CollideSettings s = still(0.002);
  s.gravity = Vec3(0, 0, -10);
  Body a = sphere(0, 0.1, Vec3::Zero()), b = sphere(1, 0.1, Vec3(0, 0, 0.2 + 0.002 + 0.016 * 3 + 10 * 0.016 * 0.016 - 1e-6));
  a.state.velocity = b.state.velocity = Vec3(0, 0, -3);  // together: no relative motion
  EXPECT_EQ(collide_two(a, b, s).points.size(), 1u);
  b.state.position.z() += 2e-6;
  EXPECT_EQ(collide_two(a, b, s).points.size(), 0u);

  Body spinning = box(0, Vec3(0.1, 0.1, 0.1), Vec3::Zero());
  Body ground = plane(1, Vec3(0, 0, -0.1 - 0.02));
  s.gravity.setZero();
  EXPECT_EQ(collide_two(spinning, ground, s).points.size(), 0u);
  spinning.state.angular_velocity = Vec3(0, 8, 0);
  EXPECT_EQ(collide_two(spinning, ground, s).points.size(), 4u);
}

TEST(NarrowPhase, PairsWithinTheMarginHaveOverlappingSweptBounds) {
  Random random(3);
  CollideSettings s;
  s.gravity = Vec3(0, 0, -9.8);
  int made = 0;
  for (int k = 0; k < 3000; ++k) {
    std::vector<Body> two{random_body(0, random, 0.5), random_body(1, random, 0.5)};
    if (k % 3 == 0) two[1].properties.motion = Motion::kinematic;
    const World w = world_of(two);
    PairManifold m;
    collide_pair(make_proxy(w, 0, s), make_proxy(w, 1, s), s, m);
    if (m.count == 0) continue;
    ++made;
    const Bounds a = swept_bounds(w, 0, s), b = swept_bounds(w, 1, s);
    EXPECT_TRUE((a.lower.array() <= b.upper.array()).all() && (b.lower.array() <= a.upper.array()).all());
  }
  EXPECT_GT(made, 500);
}

// A scene split over two ranks, either way, must give each home body the very contacts of the whole.
TEST(NarrowPhase, SameBitsWhateverTheSlotsTheRankAndTheOtherBodies) {
  Random random(4);
  CollideSettings s;
  s.gravity = Vec3(0, 0, -9.8);
  std::vector<Body> bodies;
  for (Id id = 0; id < 120; ++id) {
    bodies.push_back(random_body(id, random, 1.2));
    if (id % 10 == 0) bodies.back().properties.motion = Motion::fixed;
  }
  bodies.push_back(plane(120, Vec3(0, 0, -1)));
  const Contacts whole = contacts_of(world_of(bodies), s);
  ASSERT_GT(whole.manifolds.size(), 100u);
  for (int rank = 0; rank < 2; ++rank) {
    const auto is_guest = [&](Id id) { return id % 2 != rank; };
    const World part = world_of(bodies, is_guest);
    const Contacts seen = contacts_of(part, s);
    Contacts expected;
    for (const Manifold& m : whole.manifolds) {
      const auto is_home = [&](Id id) { return bodies[static_cast<std::size_t>(id)].properties.is_dynamic() && !is_guest(id); };
      if (!is_home(m.id_a) && !is_home(m.id_b)) continue;
      expected.manifolds.push_back(m);
      expected.manifolds.back().first = static_cast<std::uint32_t>(expected.points.size());
      expected.points.insert(expected.points.end(), whole.points.begin() + m.first, whole.points.begin() + m.first + m.count);
    }
    EXPECT_TRUE(same_bits(seen, expected)) << "rank " << rank;
    for (const Manifold& m : seen.manifolds) {
      EXPECT_EQ(part.id[m.slot_a], m.id_a);
      EXPECT_EQ(part.id[m.slot_b], m.id_b);
    }
  }
}

TEST(NarrowPhase, OrderOfManifoldsAndFeatures) {
  Random random(5);
  std::vector<Body> bodies;
  for (Id id = 0; id < 200; ++id) bodies.push_back(random_body(3 * ((id * 37) % 200), random, 1.0));
  CollideSettings s;
  s.friction = {0.1, 0.2, 0.2, 0.4}, s.material_count = 2;
  for (auto& b : bodies) b.properties.material = b.id % 2;
  Collider collider;
  Contacts c, again;
  const World w = world_of(bodies);
  collider.collide(w, s, c);
  ASSERT_GT(c.manifolds.size(), 300u);
  std::uint32_t next = 0;
  for (std::size_t i = 0; i < c.manifolds.size(); ++i) {
    const Manifold& m = c.manifolds[i];
    EXPECT_LT(m.id_a, m.id_b);
    const bool of_core = c.points[m.first].feature == core_feature;  // after that of the same pair as a whole
    if (i > 0) {
      const auto before = std::pair(c.manifolds[i - 1].id_a, c.manifolds[i - 1].id_b), own = std::pair(m.id_a, m.id_b);
      EXPECT_TRUE(before < own || (of_core && before == own));
    }
    EXPECT_EQ(m.first, next);
    EXPECT_TRUE(m.count >= 1 && m.count <= 8);
    next += m.count;
    EXPECT_NEAR(m.normal.norm(), 1, 1e-12);
    for (std::uint32_t k = m.first + 1; k < m.first + m.count; ++k) EXPECT_LT(c.points[k - 1].feature, c.points[k].feature);
    EXPECT_EQ(m.friction, m.id_a % 2 + m.id_b % 2 == 0 ? 0.1 : m.id_a % 2 + m.id_b % 2 == 1 ? 0.2 : 0.4);
  }
  EXPECT_EQ(next, c.points.size());
  collider.collide(w, s, again);
  EXPECT_TRUE(same_bits(c, again));
}

// Which of the two has the lower id only turns the normal. Two boxes are worked out in the frame of the lower id, so that
// their gaps agree to rounding only.
TEST(NarrowPhase, ExchangedIdsTurnTheNormal) {
  Random random(6);
  CollideSettings s = still(0.05);
  int seen = 0, boxes = 0;
  for (int k = 0; k < 4000; ++k) {
    Body a = random_body(0, random, 0.35), b = random_body(1, random, 0.35);
    const bool two_boxes = a.properties.shape.kind == ShapeKind::box && b.properties.shape.kind == ShapeKind::box;
    if (k % 2 == 0) a.state.velocity.setZero(), b.state.velocity.setZero();
    const Pair p = collide_two(a, b, s);
    std::swap(a.id, b.id);
    const Pair q = collide_two(a, b, s);
    if (two_boxes) {
      // the choice between two axes that are equal within the bias may fall differently
      if (std::abs(p.normal.dot(q.normal)) < 0.999999) continue;
      ASSERT_EQ(p.points.empty(), q.points.empty());
      if (!p.points.empty()) {
        EXPECT_NEAR(p.smallest_gap(), q.smallest_gap(), 1e-10);
      }
      boxes += !p.points.empty();
      continue;
    }
    ASSERT_EQ(p.points.size(), q.points.size());
    for (std::size_t i = 0; i < p.points.size(); ++i) {
      ++seen;
      EXPECT_EQ(p.points[i].gap, q.points[i].gap);
      EXPECT_EQ(p.normal, Vec3(-q.normal));
      EXPECT_LT((p.points[i].position - q.points[i].position).norm(), 1e-13);
    }
  }
  EXPECT_GT(seen, 500);
  EXPECT_GT(boxes, 200);
}

TEST(NarrowPhase, PlanarScenesStayInTheirPlane) {
  CollideSettings s = still(0.02);
  s.planar = true;
  const Quat turn(Eigen::AngleAxisd(0.3, Vec3::UnitY()));
  const Pair discs = collide_two(disc(0, 0.2, Vec3(0, 0, 0)), disc(1, 0.3, Vec3(0.3, 0, 0.4)), s);
  ASSERT_EQ(discs.points.size(), 1u);
  EXPECT_NEAR(discs.points[0].gap, 0, 1e-15);
  EXPECT_NEAR((discs.normal - Vec3(-0.6, 0, -0.8)).norm(), 0, 1e-15);

  const Pair on_plane = collide_two(box(0, Vec3(0.2, 5, 0.1), Vec3(0, 0, 0.1)), plane(1), s);
  ASSERT_EQ(on_plane.points.size(), 2u);

  const Vec3 up = turn * Vec3::UnitZ();
  const Pair boxes =
      collide_two(box(0, Vec3(0.3, 0.01, 0.1), Vec3::Zero(), turn), box(1, Vec3(0.1, 0.01, 0.2), 0.305 * up, turn), s);
  ASSERT_EQ(boxes.points.size(), 2u);
  EXPECT_LT((boxes.normal + up).norm(), 1e-14);
  for (const auto& p : boxes.points) {
    EXPECT_NEAR(p.gap, 0.005, 1e-14);
    EXPECT_EQ(p.position.y(), 0);
    EXPECT_NEAR(p.position.dot(up), 0.1025, 1e-14);
    EXPECT_NEAR(std::abs(p.position.dot(turn * Vec3::UnitX())), 0.1, 1e-14);
  }
  const Pair in_thin_box = collide_two(disc(0, 0.05, Vec3(0.29, 0, 0)), box(1, Vec3(0.3, 0.001, 0.3), Vec3::Zero()), s);
  ASSERT_EQ(in_thin_box.points.size(), 1u);
  EXPECT_EQ(in_thin_box.normal, Vec3::UnitX());  // never y, the thinnest way out
}

}  // namespace
}  // namespace unibody::narrowphase_test
