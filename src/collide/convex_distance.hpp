// Signed distance of two convex solids by their support functions: GJK where their cores are apart, EPA where they overlap
// (Gilbert, Johnson & Keerthi 1988; van den Bergen 2001). In double precision, from nothing but the pair.
#pragma once

#include <array>

#include "world/shape_type.hpp"

namespace unibody {

// A convex solid in place, or a triangle: then `nodes` are its three corners.
struct ConvexBody {
  Shape shape;
  const ConvexFunctions* functions = nullptr;
  Mat3 rotation = Mat3::Identity();
  Vec3 centre = Vec3::Zero();   // m
  double rounding = 0;          // m
  double size = 0;              // m, of its smallest extent: what lengths are compared with
  const Vec3* nodes = nullptr;  // m

  Vec3 support(const Vec3& direction) const {  // m, of the core
    if (nodes) {
      const double x = direction.dot(nodes[0]), y = direction.dot(nodes[1]), z = direction.dot(nodes[2]);
      return x >= y && x >= z ? nodes[0] : nodes[y >= z ? 1 : 2];
    }
    return centre + rotation * functions->support(shape, rotation.transpose() * direction);
  }
};

ConvexBody convex_body(const Shape& shape, const Mat3& rotation, const Vec3& centre);
ConvexBody convex_triangle(const std::array<Vec3, 3>& nodes, double size);  // refers to the nodes

struct ConvexDistance {
  Vec3 normal;      // unit, from b to a
  double gap;       // m, along it: the distance, or less the depth of the shortest way apart
  Vec3 on_a, on_b;  // m, the points that are nearest, or deepest, on the solids' surfaces
};

// False where they are more than `margin` (m) apart.
bool convex_distance(const ConvexBody& a, const ConvexBody& b, double margin, ConvexDistance& result);

enum class Cores { far, apart, together };

// The same where the cores are apart, by more than rounding; what else there is goes without a result.
Cores distance_of_cores(const ConvexBody& a, const ConvexBody& b, double margin, ConvexDistance& result);

// m, between the two solids across a direction (unit, from b to a): a lower bound of their distance, exact where they overlap in
// no direction less.
double gap_along(const ConvexBody& a, const ConvexBody& b, const Vec3& normal);

}  // namespace unibody
