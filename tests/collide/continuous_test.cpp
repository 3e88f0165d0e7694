// Continuous tests by hand, and on contacts that are exact by construction.
#include "collide/continuous.hpp"

#include "collide/moving_query.hpp"

namespace unibody::continuous_test {
namespace {

using namespace samples;

MovingPoint still(const Vec3& x) { return {x, x}; }
MovingPoint moving(const Vec3& from, const Vec3& to) { return {from, to}; }

Query point_query(const MovingPoint& p, const MovingPoint& a, const MovingPoint& b, const MovingPoint& c) {
  return {false, {p, a, b, c}};
}
Query edge_query(const MovingPoint& p0, const MovingPoint& p1, const MovingPoint& q0, const MovingPoint& q1) {
  return {true, {p0, p1, q0, q1}};
}

const Vec3 a0(0, 0, 0), b0(1, 0, 0), c0(0, 1, 0);

// The hit's time, or 2 for none; with thickness 0 unless given.
double time_of(const Query& q, double thickness = 0, double tolerance = 1e-9) {
  const ContinuousSettings settings{thickness, tolerance};
  const ContinuousHit hit = q.ask(settings);
  expect_sound(q, settings, hit, 50);
  EXPECT_TRUE(hit.proven);
  return hit.hit ? hit.time : 2;
}

TEST(Continuous, PointAndTriangleByHand) {
  const auto at = [](const Vec3& from, const Vec3& to, double d = 0) {
    return time_of(point_query(moving(from, to), still(a0), still(b0), still(c0)), d);
  };
  EXPECT_NEAR(at({0.2, 0.2, 1}, {0.2, 0.2, -1}), 0.5, 1e-9);
  EXPECT_NEAR(at({0.2, 0.2, 1}, {0.2, 0.2, -1}, 0.1), 0.45, 1e-9);
  EXPECT_NEAR(at({0.2, 0.2, 1}, {0.2, 0.2, 0}), 1, 1e-8);             // touches only at the end
  EXPECT_EQ(at({0.2, 0.2, 1}, {0.2, 0.2, 1e-8}), 2);                  // and just doesn't
  EXPECT_NEAR(at({0.2, 0.2, 1}, {0.2, 0.2, 0.125}, 0.125), 1, 1e-8);  // the same with a thickness
  EXPECT_EQ(at({0.2, 0.2, 0}, {0.2, 0.2, 5}), 0);                     // starts in contact and leaves
  EXPECT_EQ(at({0.2, 0.2, 0.05}, {0.2, 0.2, 5}, 0.1), 0);
  EXPECT_EQ(at({0.2, 0.2, 0}, {0.2, 0.2, 0}), 0);  // no motion
  EXPECT_EQ(at({0.2, 0.2, 0.5}, {0.2, 0.2, 0.5}), 2);
  EXPECT_EQ(at({0.2, 0.2, 0.5}, {0.2, 0.2, 0.5}, 0.5), 0);
  EXPECT_NEAR(at({-1, 0.25, 0}, {1, 0.25, 0}), 0.5, 1e-9);               // in the plane, through an edge
  EXPECT_NEAR(at({-1, 0, 0}, {1, 0, 0}), 0.5, 1e-9);                     // along an edge
  EXPECT_NEAR(at({-1, 1, 0}, {1, -1, 0}), 0.5, 1e-9);                    // grazes a node in the plane
  EXPECT_NEAR(at({-1, 1, 1}, {1, -1, -1}), 0.5, 1e-9);                   // hits a node
  EXPECT_NEAR(at({0.5, -1, 1}, {0.5, 1, -1}), 0.5, 1e-9);                // hits an edge
  EXPECT_NEAR(at({0.5, -1, 0.125}, {0.5, 1, 0.125}, 0.125), 0.5, 1e-4);  // grazes the thickness of an edge: distance ~ time^2
  EXPECT_NEAR(at({2, -2, 0}, {0, 2, 0}, 0), 0.5, 1e-9);                  // node b from outside
  EXPECT_EQ(at({-1, -1e-6, 0}, {1, -1e-6, 0}), 2);                       // passes by in the plane
  EXPECT_EQ(at({-1, 0.25, 1e-6}, {1, 0.25, 1e-6}), 2);                   // slides over the face
  EXPECT_EQ(at({0.2, 0.2, 1}, {5, 5, -1}), 2);
}

TEST(Continuous, MovingAndDegenerateTrianglesByHand) {
  const MovingPoint p = still(Vec3(0.25, 0.25, 0));
  // a common motion changes nothing
  const Vec3 far(1e6, -1e6, 1e6);
  EXPECT_NEAR(time_of(point_query(moving(Vec3(0.25, 0.25, 1), Vec3(0.25, 0.25, -1) + far), moving(a0, a0 + far),
                                  moving(b0, b0 + far), moving(c0, c0 + far)),
                      0, 1e-6),
              0.5, 1e-6);
  // the triangle turns inside out through the point; collapses upon it; has no area; is a point
  EXPECT_NEAR(
      time_of(point_query(p, moving(a0, a0), moving(Vec3(1, 0, 1), Vec3(1, 0, -1)), moving(Vec3(0, 1, 1), Vec3(0, 1, -1)))), 0.5,
      1e-8);
  const MovingPoint shrinks = moving(Vec3(1, 1, 1), p.start);
  EXPECT_NEAR(time_of(point_query(p, shrinks, moving(Vec3(2, 0, 3), p.start), moving(Vec3(0, 2, 1), p.start))), 1, 1e-8);
  EXPECT_NEAR(time_of(point_query(moving(Vec3(0.5, 0.25, 1), Vec3(0.5, 0.25, -1)), still(a0), still(Vec3(1, 0.5, 0)),
                                  still(Vec3(2, 1, 0)))),
              0.5, 1e-8);
  EXPECT_NEAR(time_of(point_query(moving(Vec3(0, 0, 1), Vec3(0, 0, -1)), still(a0), still(a0), still(a0))), 0.5, 1e-8);
  EXPECT_EQ(time_of(point_query(moving(Vec3(0, 1e-6, 1), Vec3(0, 1e-6, -1)), still(a0), still(a0), still(a0))), 2);
  EXPECT_EQ(time_of(point_query(still(a0), still(a0), still(a0), still(a0))), 0);
}

TEST(Continuous, EdgesByHand) {
  const MovingPoint q0 = still(Vec3(-1, 0, 0)), q1 = still(Vec3(1, 0, 0));
  const auto at = [&](const Vec3& from0, const Vec3& from1, const Vec3& motion, double d = 0) {
    return time_of(edge_query(moving(from0, from0 + motion), moving(from1, from1 + motion), q0, q1), d);
  };
  const Vec3 down(0, 0, -2);
  EXPECT_NEAR(at({0, -1, 1}, {0, 1, 1}, down), 0.5, 1e-9);  // crossing
  EXPECT_NEAR(at({0, -1, 1}, {0, 1, 1}, down, 0.25), 0.375, 1e-9);
  EXPECT_NEAR(at({-1, 0, 1}, {1, 0, 1}, down), 0.5, 1e-9);    // parallel, face on
  EXPECT_NEAR(at({-0.5, 0, 1}, {5, 0, 1}, down), 0.5, 1e-9);  // parallel, in part
  EXPECT_NEAR(at({1, 0, 1}, {2, 0, 1}, down), 0.5, 1e-9);     // parallel, end on end
  EXPECT_EQ(at({1.001, 0, 1}, {2, 0, 1}, down), 2);
  EXPECT_NEAR(at({2, 0, 0}, {3, 0, 0}, {-2, 0, 0}), 0.5, 1e-9);    // on one line
  EXPECT_NEAR(at({0, 1, 0}, {0.5, 2, 0}, {0, -2, 0}), 0.5, 1e-9);  // in one plane
  EXPECT_NEAR(at({1, -1, 1}, {1, 1, 1}, down), 0.5, 1e-9);         // grazes an end
  EXPECT_NEAR(at({1, 0, 1}, {1, 1, 1}, down), 0.5, 1e-9);          // end on end
  EXPECT_NEAR(at({0.3, 0, 1}, {0.3, 0, 1}, down), 0.5, 1e-9);      // no length
  EXPECT_NEAR(at({0, -1, 2}, {0, 1, 2}, down), 1, 1e-8);           // touches only at the end
  EXPECT_EQ(at({0, -1, 0}, {0, 1, 0}, Vec3(0, 0, 5)), 0);          // starts in contact
  EXPECT_EQ(at({0, -1, 0}, {0, 1, 0}, Vec3::Zero()), 0);
  EXPECT_EQ(at({0, -1, 1}, {0, 1, 1}, Vec3::Zero()), 2);
  EXPECT_EQ(at({-1, 0, 1e-6}, {1, 0, 1e-6}, Vec3(0.5, 0, 0)), 2);     // slides along
  EXPECT_EQ(at({-1, -0.5, 1e-6}, {1, 1, 1e-6}, Vec3(0.5, 3, 0)), 2);  // slides across
  // an edge that turns half round in the plane of another, through it
  EXPECT_NEAR(time_of(edge_query(moving(Vec3(-1, 0, 1), Vec3(-1, 0, -1)), moving(Vec3(1, 0, 3), Vec3(1, 0, -3)), q0, q1)), 0.5,
              1e-8);
  EXPECT_EQ(time_of(edge_query(still(a0), still(a0), still(a0), still(a0))), 0);
}

TEST(Continuous, WhatIsNoNumberIsAHitWithoutProof) {
  for (const double x : {std::nan(""), HUGE_VAL, 1e308}) {
    const ContinuousHit hit = point_meets_triangle(moving(Vec3(x, 1, 1), Vec3(-x, 1, 1)), still(a0), still(b0), still(c0), {});
    EXPECT_TRUE(hit.hit);
    EXPECT_FALSE(hit.proven);
    EXPECT_EQ(hit.time, 0);
  }
}

// A contact at a chosen time and place, exact in doubles: all numbers are multiples of 2^-12 below 2^12 or so, times 2^scale.
struct Built {
  Query query;
  double time, thickness;
};

class Builder {
 public:
  explicit Builder(std::uint64_t seed) : random_(seed) {}

  Built build(bool edges) {
    const double grid = pick({0.25, 0.0625, 0.015625});
    Built built;
    Query& q = built.query;
    q.edges = edges;
    for (auto& node : q.nodes) node = {on_grid(grid), on_grid(grid)};
    degenerate(q, grid);
    built.time = pick({0, 0.125, 0.25, 0.5, 0.625, 0.875, 1});
    const double u = pick({0, 0, 0.125, 0.5, 0.75, 1}), v = pick({0, 0, 0.25, 0.5, 0.875, 1});
    // the last three nodes give a point; node 0, or the whole first edge, is shifted to meet it
    const auto at = [&](std::size_t i) -> Vec3 { return (1 - built.time) * q.nodes[i].start + built.time * q.nodes[i].end; };
    const double fold = u + v > 1 && !edges ? 0 : v;
    const Vec3 from = edges ? Vec3((1 - u) * at(0) + u * at(1)) : at(0);
    const Vec3 to = edges ? Vec3((1 - v) * at(2) + v * at(3)) : Vec3((1 - u - fold) * at(1) + u * at(2) + fold * at(3));
    Vec3 shift = to - from;
    built.thickness = 0;
    if (random_(0, 1) < 0.4) {  // of whole length
      const double size = grid * pick({1, 0.25, 0.0625});
      const auto [offset, length] = whole_offset();
      shift += size * offset, built.thickness = size * length;
    }
    for (std::size_t i = 0; i < (edges ? 2 : 1); ++i) q.nodes[i].start += shift, q.nodes[i].end += shift;
    rescale(built);
    return built;
  }

 private:
  Random random_;

  double pick(std::initializer_list<double> values) {
    return values.begin()[static_cast<std::size_t>(random_(0, static_cast<double>(values.size())))];
  }
  Vec3 on_grid(double grid) { return (random_.vector(-1, 1) / grid).array().round() * grid; }

  // (1, 2, 2), (2, 3, 6), (3, 4, 0), (0, 0, 1) and their like.
  std::pair<Vec3, double> whole_offset() {
    const std::pair<Vec3, double> all[] = {{{1, 2, 2}, 3}, {{2, 3, 6}, 7}, {{3, 4, 0}, 5}, {{0, 0, 1}, 1}};
    auto [v, length] = all[static_cast<std::size_t>(random_(0, 4))];
    const auto turn = static_cast<Eigen::Index>(random_(0, 3));
    return {Vec3(pick({-1, 1}) * v[turn], pick({-1, 1}) * v[(turn + 1) % 3], pick({-1, 1}) * v[(turn + 2) % 3]), length};
  }

  // Coplanar motion, nodes that coincide, edges that are parallel or have no length, nodes on a line, common and no motion.
  void degenerate(Query& q, double grid) {
    const auto i = static_cast<std::size_t>(random_(0, 4)), j = static_cast<std::size_t>(random_(0, 4));
    switch (static_cast<int>(random_(0, 10))) {
      case 0:
        for (auto& node : q.nodes) node.start.z() = node.end.z() = 0;
        break;
      case 1:
        q.nodes[i] = q.nodes[j];
        break;
      case 2: {  // parallel throughout, or at the end
        const double stretch = pick({-1, 0.5, 1, 2});
        q.nodes[1].start = q.nodes[0].start + stretch * (q.nodes[3].start - q.nodes[2].start);
        if (random_(0, 1) < 0.7) q.nodes[1].end = q.nodes[0].end + stretch * (q.nodes[3].end - q.nodes[2].end);
        break;
      }
      case 3:
        q.nodes[3] = {2 * q.nodes[2].start - q.nodes[1].start, 2 * q.nodes[2].end - q.nodes[1].end};
        break;
      case 4:
        for (auto& node : q.nodes) node.end = node.start;
        break;
      case 5: {
        const Vec3 motion = 16 * on_grid(grid);
        for (auto& node : q.nodes) node.end = node.start + motion;
        q.nodes[i].end += on_grid(grid);
        break;
      }
      case 6:  // thin: one length is 2^-6 of the others
        for (auto& node : q.nodes) node.start.z() *= 0x1p-6, node.end.z() *= 0x1p-6;
        break;
      default:
        break;
    }
  }

  void rescale(Built& built) {
    const double scale = std::ldexp(1, static_cast<int>(pick({0, 0, 0, -60, -150, 60, 150})));
    const Vec3 offset = random_(0, 1) < 0.3 ? Vec3((random_.vector(-1, 1) * 1024).array().round() * 0x1p14) : Vec3(Vec3::Zero());
    for (auto& node : built.query.nodes) node = {scale * (node.start + offset), scale * (node.end + offset)};
    built.thickness *= scale;
  }
};

TEST(Continuous, NoExactContactIsMissed) {
  Builder builder(1);
  int proven = 0, cases = 0;
  for (int k = 0; k < 1000000; ++k) {
    const Built built = builder.build(k % 2 == 0);
    const double tolerances[] = {1e-3, 1e-6, 1e-9, 1e-12, 1e-15, 0};
    const ContinuousSettings settings{built.thickness, tolerances[k / 2 % 6] * built.query.size()};
    const ContinuousHit hit = built.query.ask(settings);
    // the construction is exact; long double, that isn't, only watches over it
    if (k % 100 == 0) {
      ASSERT_LE(built.query.distance(built.time), built.thickness + 1e-18 * built.query.size()) << k;
    }
    ASSERT_TRUE(hit.hit) << k;
    ASSERT_LE(hit.time, built.time) << k;
    if (k % 100 < 2) expect_sound(built.query, settings, hit, 20);
    if (k / 2 % 6 < 4) ++cases, proven += hit.proven;
  }
  std::cout << "exact contacts at tolerances of 1e-3 to 1e-12 of the size: " << proven << " of " << cases << " with proof\n";
  EXPECT_GT(proven, 0.99 * cases);
}

}  // namespace
}  // namespace unibody::continuous_test
