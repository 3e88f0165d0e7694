// Closest points of points, segments and triangles; lengths in m. Pure functions of their arguments.
//
// Whatever the shape (slivers, nodes that coincide, segments without length), the points returned lie on the features, and no
// other pair is closer by more than rounding: a few 1e-15 of the coordinates. Sizes below 1e-75 m count as zero.
#pragma once

#include "core/types.hpp"

namespace unibody {

// A point of a triangle a, b, c.
struct TrianglePoint {
  Vec3 weights;     // of a, b, c: none negative, sum 1; exactly 0 off the feature that the point lies on
  Vec3 point;       // m
  double distance;  // m, from the point asked about

  // Bit k is set where node k counts: 1, 2, 4 a node; 3, 6, 5 an edge; 7 the face.
  unsigned feature() const {
    return static_cast<unsigned>(weights[0] > 0) | static_cast<unsigned>(weights[1] > 0) << 1 |
           static_cast<unsigned>(weights[2] > 0) << 2;
  }
};

TrianglePoint closest_on_triangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c);

// The place, in [0, 1], of the point nearest to p on the segment from a to b.
double closest_on_segment(const Vec3& p, const Vec3& a, const Vec3& b);

struct SegmentPoints {
  double s, t;         // in [0, 1], along the first and the second
  Vec3 first, second;  // m, the points
  double distance;     // m
};

// Closest points of the segments p0 p1 and q0 q1. Of parallel ones, a pair that holds an end.
SegmentPoints closest_of_segments(const Vec3& p0, const Vec3& p1, const Vec3& q0, const Vec3& q1);

}  // namespace unibody
