// Closed formulas for each shape; the price of a new shape here is one case in each function.
#include "world/shapes.hpp"

#include <cmath>
#include <limits>
#include <numbers>

namespace unibody {

namespace {
constexpr double infinity = std::numeric_limits<double>::infinity();
}

double bounding_radius(const Shape& shape) {
  switch (shape.kind) {
    case ShapeKind::sphere:
    case ShapeKind::disc:
    case ShapeKind::particle:
      return shape.size.x();
    case ShapeKind::box:
      return shape.size.norm();
    case ShapeKind::plane:
      break;
  }
  return infinity;
}

Vec3 bounding_half_extents(const Shape& shape, const Quat& orientation) {
  switch (shape.kind) {
    case ShapeKind::sphere:
    case ShapeKind::particle:
      return Vec3::Constant(shape.size.x());
    case ShapeKind::box:
      return orientation.toRotationMatrix().cwiseAbs() * shape.size;
    case ShapeKind::disc: {
      const Vec3 axis = orientation.toRotationMatrix().col(1);
      return shape.size.x() * (1 - axis.array().square()).max(0).sqrt().matrix();
    }
    case ShapeKind::plane:
      break;
  }
  return Vec3::Constant(infinity);
}

double volume(const Shape& shape) {
  const double r = shape.size.x();
  switch (shape.kind) {
    case ShapeKind::sphere:
    case ShapeKind::particle:
      return 4 * std::numbers::pi / 3 * r * r * r;
    case ShapeKind::box:
      return 8 * shape.size.prod();
    case ShapeKind::disc:
      return std::numbers::pi * r * r;
    case ShapeKind::plane:
      break;
  }
  return 0;
}

Vec3 inertia(const Shape& shape, double mass) {
  const Vec3 s = shape.size.cwiseProduct(shape.size);
  switch (shape.kind) {
    case ShapeKind::sphere:
      return Vec3::Constant(0.4 * mass * s.x());
    case ShapeKind::box:
      return mass / 3 * Vec3(s.y() + s.z(), s.z() + s.x(), s.x() + s.y());
    case ShapeKind::disc:
      return mass * s.x() * Vec3(0.25, 0.5, 0.25);
    case ShapeKind::particle:
      return Vec3::Zero();
    case ShapeKind::plane:
      break;
  }
  return Vec3::Ones();
}

double smallest_size(const Shape& shape) {
  switch (shape.kind) {
    case ShapeKind::sphere:
    case ShapeKind::disc:
    case ShapeKind::particle:
      return 2 * shape.size.x();
    case ShapeKind::box:
      return 2 * shape.size.minCoeff();
    case ShapeKind::plane:
      break;
  }
  return infinity;
}

}  // namespace unibody
