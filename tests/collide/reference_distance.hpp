// Distances in numbers wider than double, from other formulas than the program's: Gram matrices, every feature tried.
#pragma once

#include <algorithm>
#include <cmath>

#include "core/types.hpp"

namespace unibody::samples {

using Long = long double;               // 64 bits
__extension__ typedef __float128 Quad;  // 113 bits, slow

template <class Real>
struct Wide {
  Real x, y, z;
  Wide operator+(const Wide& o) const { return {x + o.x, y + o.y, z + o.z}; }
  Wide operator-(const Wide& o) const { return {x - o.x, y - o.y, z - o.z}; }
  friend Wide operator*(Real s, const Wide& v) { return {s * v.x, s * v.y, s * v.z}; }
  Real dot(const Wide& o) const { return x * o.x + y * o.y + z * o.z; }
  Wide cross(const Wide& o) const { return {y * o.z - z * o.y, z * o.x - x * o.z, x * o.y - y * o.x}; }
  Real squared() const { return dot(*this); }
};

template <class Real>
Wide<Real> wide(const Vec3& v) {
  return {v.x(), v.y(), v.z()};
}

template <class Real>
double root(Real squared) {
  return static_cast<double>(std::sqrt(static_cast<Long>(squared)));
}

// All of them squared.
template <class Real>
Real reference_distance(const Wide<Real>& p, const Wide<Real>& a, const Wide<Real>& b) {
  const Wide<Real> e = b - a, r = p - a;
  const Real ee = e.squared();
  const Real t = ee > 0 ? std::clamp<Real>(e.dot(r) / ee, 0, 1) : 0;
  return (r - t * e).squared();
}

template <class Real>
Real reference_distance(const Wide<Real>& p, const Wide<Real>& a, const Wide<Real>& b, const Wide<Real>& c) {
  Real best = std::min({reference_distance(p, a, b), reference_distance(p, b, c), reference_distance(p, c, a)});
  const Wide<Real> u = b - a, v = c - a, r = p - a;
  const Real uu = u.dot(u), uv = u.dot(v), vv = v.dot(v), ur = u.dot(r), vr = v.dot(r), det = uu * vv - uv * uv;
  if (det > 0) {
    const Real s = (vv * ur - uv * vr) / det, t = (uu * vr - uv * ur) / det;
    if (s >= 0 && t >= 0 && s + t <= 1) best = std::min(best, (r - s * u - t * v).squared());
  }
  return best;
}

template <class Real>
Real reference_distance_of_segments(const Wide<Real>& p0, const Wide<Real>& p1, const Wide<Real>& q0, const Wide<Real>& q1) {
  Real best = std::min({reference_distance(p0, q0, q1), reference_distance(p1, q0, q1), reference_distance(q0, p0, p1),
                        reference_distance(q1, p0, p1)});
  const Wide<Real> u = p1 - p0, v = q1 - q0, r = q0 - p0;
  const Real uu = u.dot(u), uv = u.dot(v), vv = v.dot(v), ur = u.dot(r), vr = v.dot(r), det = uu * vv - uv * uv;
  if (det > 0) {
    const Real s = (vv * ur - uv * vr) / det, t = (uv * ur - uu * vr) / det;
    if (s >= 0 && s <= 1 && t >= 0 && t <= 1) best = std::min(best, (r + t * v - s * u).squared());
  }
  return best;
}

}  // namespace unibody::samples
