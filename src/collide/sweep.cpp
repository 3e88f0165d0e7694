#include "collide/sweep.hpp"

#include <algorithm>
#include <cmath>

#include "collide/box_box.hpp"

namespace unibody {

Sweep sweep_round_round(const Proxy& a, const Proxy& b, const Vec3& velocity, double limit, Impact& impact) {
  const Vec3 between = a.position - b.position;
  const double sum = a.half.x() + b.half.x();
  const double c = between.squaredNorm() - sum * sum;
  if (c <= 0) return Sweep::overlap;
  const double closing = -between.dot(velocity);
  if (closing <= 0) return Sweep::miss;
  const double discriminant = closing * closing - velocity.squaredNorm() * c;
  if (discriminant < 0) return Sweep::miss;
  impact.time = c / (closing + std::sqrt(discriminant));
  return impact.time <= limit ? Sweep::hit : Sweep::miss;
}

// The distance from a point that moves along a line to a convex body is a convex function of time, so Newton's method comes to
// the first root from before it and never oversteps it.
Sweep sweep_round_box(const Proxy& a, const Proxy& b, const Vec3& velocity, double limit, Impact& impact) {
  const Vec3 start = b.rotation.transpose() * (a.position - b.position);
  const Vec3 v = b.rotation.transpose() * velocity;
  const double r = a.half.x();
  for (int i = 0; i < 64; ++i) {
    const Vec3 p = start + impact.time * v;
    const Vec3 out = p - p.cwiseMax(-b.half).cwiseMin(b.half);
    const double distance = out.norm(), gap = distance - r;
    if (gap <= 1e-9 * r) return i == 0 ? Sweep::overlap : Sweep::hit;
    const double closing = -out.dot(v) / distance;
    if (closing <= 0) return Sweep::miss;
    impact.time += gap / closing;
    if (!(impact.time <= limit)) return Sweep::miss;
  }
  return Sweep::hit;
}

namespace {

// The times at which two boxes begin and cease to overlap along every axis tried.
struct Span {
  double entry = -HUGE_VAL, exit = HUGE_VAL;
  bool apart = false;  // some axis separates them and goes on doing so

  // Returns the time of entry on this axis, or -infinity where they overlap from the start.
  double add(double offset, double speed, double radii) {
    const double gap = std::abs(offset) - radii;
    const double closing = offset < 0 ? speed : -speed;
    if (closing > 0) exit = std::min(exit, (std::abs(offset) + radii) / closing);
    if (closing < 0 && gap <= 0) exit = std::min(exit, gap / closing);
    if (gap <= 0) return -HUGE_VAL;
    if (closing <= 0) {
      apart = true;
      return HUGE_VAL;
    }
    entry = std::max(entry, gap / closing);
    return gap / closing;
  }
};

}  // namespace

Sweep sweep_box_box(const Proxy& a, const Proxy& b, const Vec3& velocity, double limit, Impact& impact) {
  const BoxRelation r = relate_boxes(a, b);
  const Vec3 v = -(a.rotation.transpose() * velocity);  // b's relative to a, in a's frame
  const Vec3 &ha = a.half, &hb = b.half;
  Span span;
  double face_time = -HUGE_VAL, edge_time = -HUGE_VAL;
  int face = 0, edge = 0;
  for (int i = 0; i < 3; ++i) {
    const double t =
        span.add(r.offset[i], v[i], ha[i] + r.cosine[i][0] * hb[0] + r.cosine[i][1] * hb[1] + r.cosine[i][2] * hb[2]);
    if (t > face_time) face_time = t, face = i;
  }
  for (int j = 0; j < 3; ++j) {
    double offset = 0, speed = 0, radii = hb[j];
    for (int i = 0; i < 3; ++i)
      offset += r.offset[i] * r.turn[i][j], speed += v[i] * r.turn[i][j], radii += r.cosine[i][j] * ha[i];
    const double t = span.add(offset, speed, radii);
    if (t > face_time) face_time = t, face = 3 + j;
  }
  for (int i = 0; i < 3 && !span.apart; ++i) {
    const int i1 = (i + 1) % 3, i2 = (i + 2) % 3;
    for (int j = 0; j < 3; ++j) {
      const int j1 = (j + 1) % 3, j2 = (j + 2) % 3;
      const double x = -r.turn[i2][j], y = r.turn[i1][j];
      if (x * x + y * y < 1e-6) continue;
      const double radii =
          ha[i1] * r.cosine[i2][j] + ha[i2] * r.cosine[i1][j] + hb[j1] * r.cosine[i][j2] + hb[j2] * r.cosine[i][j1];
      const double t = span.add(x * r.offset[i1] + y * r.offset[i2], x * v[i1] + y * v[i2], radii);
      if (t > edge_time) edge_time = t, edge = 6 + 3 * i + j;
    }
  }
  if (span.apart || span.entry > span.exit || span.entry > limit) return Sweep::miss;
  if (span.entry < 0) return Sweep::overlap;
  impact.time = span.entry;
  const double bias = 1e-3 * std::min(ha.minCoeff(), hb.minCoeff());  // m; as in find_axis
  impact.axis = (edge_time - face_time) * velocity.norm() > bias ? edge : face;
  return Sweep::hit;
}

}  // namespace unibody
