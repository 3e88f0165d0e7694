// Spheres, discs, particles, boxes and planes: closed formulas.
#include <cmath>
#include <limits>
#include <numbers>

#include "world/shape_type.hpp"

namespace unibody {

namespace {

constexpr ShapeLength radius_key[] = {{"radius", "radius"}};

Shape make_sphere(std::span<const double> v) { return {ShapeKind::sphere, Vec3(v[0], 0, 0)}; }
Shape make_disc(std::span<const double> v) { return {ShapeKind::disc, Vec3(v[0], 0, 0)}; }
Shape make_particle(std::span<const double> v) { return {ShapeKind::particle, Vec3(v[0], 0, 0)}; }

double radius_of(const Shape& s) { return s.size.x(); }
double diameter_of(const Shape& s) { return 2 * s.size.x(); }
Vec3 ball_extents(const Shape& s, const Mat3&) { return Vec3::Constant(s.size.x()); }
double ball_volume(const Shape& s) { return 4 * std::numbers::pi / 3 * s.size.x() * s.size.x() * s.size.x(); }
Vec3 ball_inertia(const Shape& s, double mass) { return Vec3::Constant(0.4 * mass * (s.size.x() * s.size.x())); }
Vec3 no_inertia(const Shape&, double) { return Vec3::Zero(); }

Vec3 centre(const Shape&, const Vec3&) { return Vec3::Zero(); }
void centre_feature(const Shape&, const Vec3&, SupportFeature& f) { f.add(Vec3::Zero()); }
bool ball_contains(const Shape& s, const Vec3& p) { return p.squaredNorm() <= s.size.x() * s.size.x(); }
constexpr ConvexFunctions ball{radius_of, centre, centre_feature, ball_contains};

Vec3 disc_extents(const Shape& s, const Mat3& rotation) {
  const Vec3 axis = rotation.col(1);
  return s.size.x() * (1 - axis.array().square()).max(0).sqrt().matrix();
}
double disc_area(const Shape& s) { return std::numbers::pi * s.size.x() * s.size.x(); }
Vec3 disc_inertia(const Shape& s, double mass) { return mass * (s.size.x() * s.size.x()) * Vec3(0.25, 0.5, 0.25); }

double box_radius(const Shape& s) { return s.size.norm(); }
Vec3 box_extents(const Shape& s, const Mat3& rotation) { return rotation.cwiseAbs() * s.size; }
double box_volume(const Shape& s) { return 8 * s.size.prod(); }
Vec3 box_inertia(const Shape& shape, double mass) {
  const Vec3 s = shape.size.cwiseProduct(shape.size);
  return mass / 3 * Vec3(s.y() + s.z(), s.z() + s.x(), s.x() + s.y());
}
double box_smallest(const Shape& s) { return 2 * s.size.minCoeff(); }

double none(const Shape&) { return 0; }
Vec3 box_support(const Shape& s, const Vec3& d) {
  return {d.x() < 0 ? -s.size.x() : s.size.x(), d.y() < 0 ? -s.size.y() : s.size.y(), d.z() < 0 ? -s.size.z() : s.size.z()};
}
void box_feature(const Shape& s, const Vec3& d, SupportFeature& f) {
  int k = 0;
  for (int i = 1; i < 3; ++i)
    if (std::abs(d[i]) > std::abs(d[k])) k = i;
  const double side = d[k] < 0 ? -1 : 1;
  const int u = (k + 1) % 3, v = (k + 2) % 3;
  constexpr double su[4] = {1, -1, -1, 1}, sv[4] = {1, 1, -1, -1};
  for (int i = 0; i < 4; ++i) {
    Vec3 corner;
    corner[k] = side * s.size[k], corner[u] = su[i] * s.size[u], corner[v] = side * sv[i] * s.size[v];
    f.add(corner);
  }
  f.normal = side * Vec3::Unit(k);
}
bool box_contains(const Shape& s, const Vec3& p) { return (p.cwiseAbs().array() <= s.size.array()).all(); }
constexpr ConvexFunctions box{none, box_support, box_feature, box_contains};

constexpr double infinity = std::numeric_limits<double>::infinity();
double infinite(const Shape&) { return infinity; }
Vec3 infinite_extents(const Shape&, const Mat3&) { return Vec3::Constant(infinity); }
Vec3 unit_inertia(const Shape&, double) { return Vec3::Ones(); }

}  // namespace

const ShapeType sphere_type{ShapeKind::sphere, radius_key,   make_sphere, radius_of, ball_extents,
                            ball_volume,       ball_inertia, diameter_of, &ball};
const ShapeType disc_type{ShapeKind::disc, radius_key,   make_disc,   radius_of, disc_extents,
                          disc_area,       disc_inertia, diameter_of, nullptr};
const ShapeType particle_type{ShapeKind::particle, radius_key, make_particle, radius_of, ball_extents,
                              ball_volume,         no_inertia, diameter_of,   &ball};
const ShapeType box_type{ShapeKind::box, {}, nullptr, box_radius, box_extents, box_volume, box_inertia, box_smallest, &box};
const ShapeType plane_type{ShapeKind::plane, {}, nullptr, infinite, infinite_extents, none, unit_inertia, infinite, nullptr};

}  // namespace unibody
