// Contact points of one triangle of a mesh or cloth with one rigid body. Pure functions of their arguments.
//
// A triangle has two sides and no thickness; a body is pushed to the side where its centre is, and a node that is inside a box,
// out through the nearest face. Whoever uses these for bodies deeper in than half their size needs a continuous test instead.
// A node or an edge that several triangles share makes the same points for each: the caller keeps one of them.
#pragma once

#include <array>
#include <span>

#include "core/types.hpp"

namespace unibody {

using TriangleNodes = std::array<Vec3, 3>;  // m

// Twice its area long; counter-clockwise corners are seen from where it points to.
inline Vec3 face_normal(const TriangleNodes& x) { return (x[1] - x[0]).cross(x[2] - x[0]); }

struct TriangleContact {
  Vec3 position;          // m, half way across the gap
  Vec3 normal;            // unit, from the triangle to the body
  Vec3 weights;           // barycentric, of the point on the triangle: none negative, sum 1
  double gap;             // m, along the normal; positive when open
  std::uint32_t feature;  // of a box: 0..7 its corner (bit k: positive side of axis k), 8 + node, 11 + 3 box edge + triangle edge
};

struct TriangleContacts {
  static constexpr int capacity = 8 + 3 + 36;
  int count = 0;
  std::array<TriangleContact, capacity> points;  // ascending in feature
};

// The gaps (m) of the points that are kept: -depth <= gap <= margin.
struct TriangleReach {
  double margin, depth;
};

// `beyond`: points (m) by which the surface goes on about flat behind the triangle's edges, so that the way over those is no way
// out. Corners of the box over the face and the edges of the triangle, nodes of the triangle at the box, edges across edges. The
// smallest gap of two that are apart is their distance, exactly up to rounding; no point of two that overlap is deeper than the
// shortest way out. Directions may lean 0.05 rad out of the range of their features, so that flat contacts keep their points. Box
// edge 4 k + i runs along axis k; bit 0 of i is set on the positive side of axis k + 1, bit 1 on that of k + 2. Triangle edge i
// runs from node i to i + 1. All modulo 3.
void box_triangle(const Vec3& centre, const Mat3& rotation, const Vec3& half, const TriangleNodes& triangle,
                  const TriangleReach& reach, TriangleContacts& out, std::span<const Vec3> beyond = {});

}  // namespace unibody
