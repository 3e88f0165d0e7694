// A solid cylinder about the z axis.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "world/shape_type.hpp"

namespace unibody {

namespace {

constexpr ShapeLength keys[] = {{"radius", "radius of the ends"}, {"length", "length along z"}};
constexpr double steepest_cap = 0.7071;  // cosine of the angle to the axis up to which a cap faces a direction
constexpr int rim = 8;                   // points of a cap
constexpr double rolls = 0.05;           // tangent of the tilt from which on it rolls over its rim

Shape make(std::span<const double> v) { return {ShapeKind::cylinder, Vec3(v[0], v[0], 0.5 * v[1])}; }

double bounding(const Shape& s) { return std::hypot(s.size.x(), s.size.z()); }
Vec3 extents(const Shape& s, const Mat3& rotation) {
  const Vec3 axis = rotation.col(2);
  return s.size.z() * axis.cwiseAbs() + s.size.x() * (1 - axis.array().square()).max(0).sqrt().matrix();
}
double solid_volume(const Shape& s) { return 2 * std::numbers::pi * s.size.x() * s.size.x() * s.size.z(); }
Vec3 solid_inertia(const Shape& s, double mass) {
  const double r2 = s.size.x() * s.size.x(), across = mass * (r2 / 4 + s.size.z() * s.size.z() / 3);
  return {across, across, 0.5 * mass * r2};
}
double shortest(const Shape& s) { return 2 * std::min(s.size.x(), s.size.z()); }

double sharp(const Shape&) { return 0; }

Vec3 on_rim(const Shape& s, double x, double y, double z) {
  const double length = std::sqrt(x * x + y * y), scale = length > 0 ? s.size.x() / length : 0;
  return length > 0 ? Vec3(scale * x, scale * y, z) : Vec3(s.size.x(), 0, z);
}
Vec3 support(const Shape& s, const Vec3& d) { return on_rim(s, d.x(), d.y(), d.z() < 0 ? -s.size.z() : s.size.z()); }

// Eight points of the rim, fixed in the body; of a tilted cap the one that is furthest out as well.
void cap(const Shape& s, const Vec3& d, SupportFeature& f) {
  const double side = d.z() < 0 ? -1 : 1, z = side * s.size.z();
  const double diagonal = std::numbers::sqrt2 / 2;
  constexpr double none = -1;
  const double x[rim] = {1, diagonal, 0, -diagonal, -1, -diagonal, 0, diagonal};
  const double y[rim] = {0, diagonal, 1, diagonal, 0, -diagonal, -1, -diagonal};
  const double across = std::sqrt(d.x() * d.x() + d.y() * d.y());
  const bool tilted = across > rolls * std::abs(d.z());
  double furthest = none;
  for (int k = 0; k < rim; ++k) furthest = std::max(furthest, (x[k] * d.x() + y[k] * d.y()));
  const bool between = tilted && furthest < (1 - 1e-9) * across;
  for (int k = 0; k < rim; ++k) {
    const int i = side > 0 ? k : rim - 1 - k, j = side > 0 ? (k + 1) % rim : (2 * rim - 2 - k) % rim;
    f.add({s.size.x() * x[i], s.size.x() * y[i], z});
    const bool after = side * (x[i] * d.y() - y[i] * d.x()) > 0, before = side * (d.x() * y[j] - d.y() * x[j]) > 0;
    if (between && after && before) f.add(on_rim(s, d.x(), d.y(), z));
  }
  f.normal = Vec3(0, 0, side);
}

void feature(const Shape& s, const Vec3& d, SupportFeature& f) {
  const double length = d.norm();
  if (std::abs(d.z()) >= steepest_cap * length) return cap(s, d, f);
  for (const double side : {-1.0, 1.0}) f.add(on_rim(s, d.x(), d.y(), side * s.size.z()));
  f.normal = Vec3(d.x(), d.y(), 0).normalized();
}
bool contains(const Shape& s, const Vec3& p) { return std::hypot(p.x(), p.y()) <= s.size.x() && std::abs(p.z()) <= s.size.z(); }
constexpr ConvexFunctions convex{sharp, support, feature, contains};

}  // namespace

const ShapeType cylinder_type{ShapeKind::cylinder, keys, make, bounding, extents, solid_volume, solid_inertia, shortest, &convex};

}  // namespace unibody
