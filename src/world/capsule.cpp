// A capsule: all that is within a radius of a segment of the z axis.
#include <cmath>
#include <numbers>

#include "world/shape_type.hpp"

namespace unibody {

namespace {

constexpr ShapeLength keys[] = {{"radius", "radius of the tube and its caps"},
                                {"length", "length between the centres of the caps, along z"}};

double radius(const Shape& s) { return s.size.x(); }
double half_segment(const Shape& s) { return s.size.z() - s.size.x(); }
Shape make(std::span<const double> v) { return {ShapeKind::capsule, Vec3(v[0], v[0], v[0] + 0.5 * v[1])}; }

double bounding(const Shape& s) { return s.size.z(); }
Vec3 extents(const Shape& s, const Mat3& rotation) { return (half_segment(s) * rotation.col(2).cwiseAbs()).array() + radius(s); }
double tube_volume(const Shape& s) { return 2 * std::numbers::pi * radius(s) * radius(s) * half_segment(s); }
double caps_volume(const Shape& s) { return 4 * std::numbers::pi / 3 * radius(s) * radius(s) * radius(s); }
double solid_volume(const Shape& s) { return tube_volume(s) + caps_volume(s); }

// The inertia of the tube and of two half spheres, whose centres of mass are 3/8 r beyond the tube's ends.
Vec3 solid_inertia(const Shape& s, double mass) {
  const double r = radius(s), h = half_segment(s), all = solid_volume(s);
  const double tube = mass * tube_volume(s) / all, caps = mass * caps_volume(s) / all;
  const double along = 0.5 * tube * r * r + 0.4 * caps * r * r;
  const double across = tube * (r * r / 4 + h * h / 3) + caps * (0.4 * r * r + h * h + 0.75 * h * r);
  return {across, across, along};
}
double shortest(const Shape& s) { return 2 * radius(s); }

Vec3 support(const Shape& s, const Vec3& d) { return {0, 0, d.z() < 0 ? -half_segment(s) : half_segment(s)}; }
void feature(const Shape& s, const Vec3&, SupportFeature& f) {
  f.add({0, 0, -half_segment(s)});
  f.add({0, 0, half_segment(s)});
}
bool contains(const Shape& s, const Vec3& p) {
  return Vec3(p.x(), p.y(), std::max(0.0, std::abs(p.z()) - half_segment(s))).norm() <= radius(s);
}
constexpr ConvexFunctions convex{radius, support, feature, contains};

}  // namespace

const ShapeType capsule_type{ShapeKind::capsule, keys, make, bounding, extents, solid_volume, solid_inertia, shortest, &convex};

}  // namespace unibody
