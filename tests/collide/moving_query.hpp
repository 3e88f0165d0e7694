// A question to the continuous tests, and what must hold for every answer.
#pragma once

#include <gtest/gtest.h>

#include "collide/bodies.hpp"
#include "collide/continuous.hpp"
#include "collide/reference_distance.hpp"

namespace unibody::samples {

// Four moving nodes: a point and a triangle, or the ends of two edges.
struct Query {
  bool edges = false;
  std::array<MovingPoint, 4> nodes;

  ContinuousHit ask(const ContinuousSettings& settings) const {
    const auto& n = nodes;
    return edges ? edge_meets_edge(n[0], n[1], n[2], n[3], settings) : point_meets_triangle(n[0], n[1], n[2], n[3], settings);
  }
  // Seen from where the last node starts: far from the origin, long double has too few bits.
  template <class Real>
  Wide<Real> node(std::size_t i, Real t) const {
    const Wide<Real> origin = wide<Real>(nodes[3].start);
    return (1 - t) * (wide<Real>(nodes[i].start) - origin) + t * (wide<Real>(nodes[i].end) - origin);
  }
  double distance(Long t) const {
    const auto a = node(0, t), b = node(1, t), c = node(2, t), d = node(3, t);
    return root(edges ? reference_distance_of_segments(a, b, c, d) : reference_distance(a, b, c, d));
  }
  double size() const {  // of the largest difference
    double largest = 0;
    for (const auto& a : nodes)
      for (const auto& b : nodes) largest = std::max({largest, (a.start - b.start).norm(), (a.end - b.end).norm()});
    return largest;
  }
};

// What holds for every answer: nothing nearer than the thickness before the hit, and at a proven hit not much more than it.
inline void expect_sound(const Query& q, const ContinuousSettings& settings, const ContinuousHit& hit, int steps) {
  const double rounding = 1e-14 * q.size();
  const double until = hit.hit ? hit.time : 1;
  for (int k = 0; k <= steps && until > 0; ++k)
    ASSERT_GT(q.distance(static_cast<Long>(until) * k / steps), settings.thickness - 1e-18 * q.size());
  if (!hit.hit) return;
  const double there = q.distance(hit.time);
  ASSERT_NEAR(there, hit.distance, rounding);
  if (hit.proven) {
    ASSERT_LE(there, settings.thickness + settings.tolerance + rounding);
  }
  const auto side = [&](std::size_t from, std::size_t to) {
    Wide<Long> mean{};
    for (std::size_t k = from; k < to; ++k) mean = mean + Long{hit.weights[k]} * q.node(k, Long{hit.time});
    return mean;
  };
  const std::size_t second = q.edges ? 2 : 1;
  ASSERT_NEAR(root((side(0, second) - side(second, 4)).squared()), hit.distance, rounding);
}

inline Query random_query(Random& random, bool edges, double reach) {
  Query q{edges, {}};
  for (auto& node : q.nodes) {
    node.start = random.vector(-1, 1);
    node.end = node.start + random.vector(-reach, reach);
  }
  return q;
}

}  // namespace unibody::samples
