// What a kind of shape must say of itself: one struct of functions in one file, and one line in the list (shapes.cpp).
#pragma once

#include <span>

#include "world/shapes.hpp"

namespace unibody {

// What of a convex core faces a direction: a point, a segment or a polygon. In the order of its corners a polygon turns
// counterclockwise as seen from outside.
struct SupportFeature {
  static constexpr int capacity = 64;
  int count = 0;
  Vec3 corners[capacity];      // m, body frame
  Vec3 normal = Vec3::Zero();  // unit, outwards: of a polygon, or of a side that is curved one way; else 0

  void add(const Vec3& corner) {
    if (count < capacity) corners[count++] = corner;
  }
};

// A convex solid is a core and all that is within a radius of it. Directions, in the body frame, need not be of length 1.
struct ConvexFunctions {
  double (*rounding)(const Shape& shape);                                               // m, the radius
  Vec3 (*support)(const Shape& shape, const Vec3& direction);                           // m, the core's furthest point
  void (*feature)(const Shape& shape, const Vec3& direction, SupportFeature& feature);  // of the core
  bool (*contains)(const Shape& shape, const Vec3& point);                              // m, body frame; the solid, not the core
};

// A length of a shape by its key in the scene file (m, > 0), and what it is.
struct ShapeLength {
  const char *key, *about;
};

struct ShapeType {
  ShapeKind kind;
  std::span<const ShapeLength> lengths;  // those that give its size; empty: it is read by hand
  Shape (*make)(std::span<const double> lengths);
  double (*bounding_radius)(const Shape& shape);
  Vec3 (*half_extents)(const Shape& shape, const Mat3& rotation);
  double (*volume)(const Shape& shape);
  Vec3 (*inertia)(const Shape& shape, double mass);
  double (*smallest_size)(const Shape& shape);
  const ConvexFunctions* convex;  // null: no convex solid
};

const ShapeType& type_of(ShapeKind kind);

extern const ShapeType sphere_type, box_type, plane_type, disc_type, particle_type, capsule_type, cylinder_type, hull_type,
    compound_type, mesh_type;

}  // namespace unibody
