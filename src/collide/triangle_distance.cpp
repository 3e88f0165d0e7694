#include "collide/triangle_distance.hpp"

#include <algorithm>
#include <cmath>

namespace unibody {

namespace {

// The end itself where t is 1: a + (b - a) may differ from b.
Vec3 along(const Vec3& a, const Vec3& b, double t) { return t == 1 ? b : Vec3(a + t * (b - a)); }

// The place, in [0, 1], of the point nearest to the origin on the segment from a along `edge`.
double nearest_to_origin(const Vec3& a, const Vec3& edge) {
  const double squared = edge.squaredNorm();
  return squared > 0 ? std::clamp(-edge.dot(a) / squared, 0.0, 1.0) : 0.0;
}

// The foot of the origin on the plane, if it lies inside the triangle. Each weight is the ratio of two areas, none of them a
// difference of the others, so that its sign is right up to rounding.
bool foot_on_face(const Vec3& a, const Vec3& b, const Vec3& c, Vec3& weights, Vec3& foot) {
  const Vec3 ab = b - a, ac = c - a, normal = ab.cross(ac);
  const double squared = normal.squaredNorm();
  if (!(squared > 0)) return false;
  weights = Vec3(normal.dot(b.cross(c - b)), normal.dot(ac.cross(a)), normal.dot(a.cross(ab)));
  if (!(weights.minCoeff() > 0)) return false;
  weights /= weights.sum();
  foot = a + weights[1] * ab + weights[2] * ac;
  if (squared < 0.01 * ab.squaredNorm() * ac.squaredNorm()) {
    // the weights of a sliver are off by rounding over its height: once more, for what the foot is off in the plane
    const Vec3 off = foot - normal * (normal.dot(foot) / squared);
    const double of_b = normal.dot(ac.cross(off)) / squared, of_c = normal.dot(off.cross(ab)) / squared;
    weights += Vec3(-of_b - of_c, of_b, of_c);
    if (!(weights.minCoeff() > 0)) return false;
    foot = a + weights[1] * ab + weights[2] * ac;
  }
  return true;
}

// Keeps what is nearer to the origin.
void keep_nearer(TrianglePoint& best, const Vec3& weights, const Vec3& from_origin) {
  const double distance = from_origin.norm();
  if (distance < best.distance) best = {weights, from_origin, distance};
}

}  // namespace

double closest_on_segment(const Vec3& p, const Vec3& a, const Vec3& b) { return nearest_to_origin(a - p, b - a); }

// All four features are tried rather than told apart by signs, which rounding may get wrong on slivers. Seen from p, so that
// errors don't grow with the distance from the origin.
TrianglePoint closest_on_triangle(const Vec3& p, const Vec3& a0, const Vec3& b0, const Vec3& c0) {
  const Vec3 a = a0 - p, b = b0 - p, c = c0 - p;
  TrianglePoint best{Vec3::Zero(), Vec3::Zero(), HUGE_VAL};
  Vec3 weights, foot;
  if (foot_on_face(a, b, c, weights, foot)) keep_nearer(best, weights, foot);
  const double ab = nearest_to_origin(a, b - a), bc = nearest_to_origin(b, c - b), ca = nearest_to_origin(c, a - c);
  keep_nearer(best, Vec3(1 - ab, ab, 0), along(a, b, ab));
  keep_nearer(best, Vec3(0, 1 - bc, bc), along(b, c, bc));
  keep_nearer(best, Vec3(ca, 0, 1 - ca), along(c, a, ca));
  best.point += p;
  return best;
}

// Between two parallel lines there is no other pair than those at the ends.
SegmentPoints closest_of_segments(const Vec3& p0, const Vec3& p1, const Vec3& q0, const Vec3& q1) {
  const Vec3 u = p1 - p0, v = q1 - q0, r = q0 - p0, normal = u.cross(v);
  const Vec3 from_ends[2][2] = {{r, q1 - p0}, {q0 - p1, q1 - p1}};  // from p_i to q_j
  SegmentPoints best{0, 0, p0, q0, HUGE_VAL};
  const auto keep_nearer = [&](double s, double t) {
    // from the end that is nearer, where the rounding is less
    const Vec3& ends = from_ends[s == 1][t == 1];
    const double distance = (ends + (t == 1 ? 0 : t) * v - (s == 1 ? 0 : s) * u).norm();
    if (distance < best.distance) best.s = s, best.t = t, best.distance = distance;
  };
  const double squared = normal.squaredNorm();
  if (squared > 0) {  // the common perpendicular, if it meets both within their length
    double s = r.cross(v).dot(normal) / squared, t = r.cross(u).dot(normal) / squared;
    if (s > 0 && s < 1 && t > 0 && t < 1) {
      // nearly parallel: one coordinate may be far off, but not if it is found again from the other
      t = nearest_to_origin(r - s * u, v);
      s = nearest_to_origin(-r - t * v, u);
      keep_nearer(s, t);
    }
  }
  keep_nearer(0, nearest_to_origin(r, v));
  keep_nearer(1, nearest_to_origin(from_ends[1][0], v));
  keep_nearer(nearest_to_origin(-r, u), 0);
  keep_nearer(nearest_to_origin(-from_ends[0][1], u), 1);
  best.first = along(p0, p1, best.s), best.second = along(q0, q1, best.t);
  return best;
}

}  // namespace unibody
