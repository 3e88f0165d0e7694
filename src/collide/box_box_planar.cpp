// Boxes turned about y only: rectangles in the x-z plane. Four axes, and two points rather than four.
#include <algorithm>
#include <cmath>

#include "collide/box_edges.hpp"
#include "collide/shape_pairs.hpp"

namespace unibody {

namespace {

using Vec2 = Eigen::Vector2d;  // (x, z)

struct Rectangle {
  Vec2 centre, axis[2], half;
};

Rectangle rectangle(const Proxy& p, const Vec3& origin) {
  const Vec3 d = p.position - origin;
  return {{d.x(), d.z()}, {{p.rotation(0, 0), p.rotation(2, 0)}, {p.rotation(0, 2), p.rotation(2, 2)}}, {p.half.x(), p.half.z()}};
}

double reach(const Rectangle& r, const Vec2& direction) {
  return r.half[0] * std::abs(r.axis[0].dot(direction)) + r.half[1] * std::abs(r.axis[1].dot(direction));
}

Vec3 lift(const Vec2& v) { return {v.x(), 0, v.y()}; }

}  // namespace

void box_box_planar(const Proxy& a, const Proxy& b, const PairSettings& settings, PairManifold& out) {
  const Rectangle box[2] = {rectangle(a, a.position), rectangle(b, a.position)};
  const Vec2 between = box[1].centre - box[0].centre;
  double separation = -HUGE_VAL;
  int best = 0;
  const double bias = 1e-4 * std::min(box[0].half.minCoeff(), box[1].half.minCoeff());
  for (int k = 0; k < 4; ++k) {
    const Vec2& axis = box[k / 2].axis[k % 2];
    const double s = std::abs(axis.dot(between)) - (reach(box[0], axis) + reach(box[1], axis));
    if (s > separation + (k >= 2 && best < 2 ? bias : 0)) separation = s, best = k;
  }
  if (separation > settings.margin) return;
  if (manifold_of_meeting_edges(a, b, relate_boxes(a, b), true, settings.margin, out)) return;

  // x: the reference rectangle, y: the other; n from x to y
  const Rectangle &x = box[best / 2], &y = box[1 - best / 2];
  Vec2 n = x.axis[best % 2];
  if (n.dot(y.centre - x.centre) < 0) n = -n;
  const Vec2 side = x.axis[1 - best % 2];
  const int opposed = std::abs(y.axis[1].dot(n)) > std::abs(y.axis[0].dot(n));
  const Vec2 down = y.axis[opposed].dot(n) > 0 ? Vec2(-y.axis[opposed]) : y.axis[opposed];
  const Vec2 middle = y.centre + y.half[opposed] * down, along = y.half[1 - opposed] * y.axis[1 - opposed];

  // the part of y's edge middle + t along, |t| <= 1, that lies over x's edge
  const double slope = side.dot(along), start = side.dot(middle - x.centre), limit = x.half[1 - best % 2];
  double from = -1, to = 1;
  if (slope != 0) {
    const double t1 = (-limit - start) / slope, t2 = (limit - start) / slope;
    from = std::max(from, std::min(t1, t2)), to = std::min(to, std::max(t1, t2));
  } else if (std::abs(start) > limit) {
    to = -2;
  }
  if (from > to) {  // beside each other: the corner that comes nearest
    from = to = n.dot(along) > 0 ? -1 : 1;
  }
  out.normal = lift(best < 2 ? Vec2(-n) : n);
  const double ends[2] = {from, to};
  for (std::uint32_t e = 0; e < (from < to ? 2u : 1u); ++e) {
    const Vec2 point = middle + ends[e] * along;
    const double gap = n.dot(point - x.centre) - x.half[best % 2];
    if (gap > settings.margin) continue;
    out.add(lift(point - 0.5 * gap * n), gap, static_cast<std::uint32_t>(best) << 1 | e);
  }
}

}  // namespace unibody
