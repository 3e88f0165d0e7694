// Whether an edge goes through a triangle, without error.
//
// Signs of determinants are taken from doubles where a bound on their rounding allows it (J. R. Shewchuk, Adaptive precision
// floating-point arithmetic and fast robust geometric predicates, 1997), and from sums of doubles without rounding elsewhere.
// Exact while every coordinate is 0 or between 1e-89 and 1e99 in absolute value.
#pragma once

#include "core/types.hpp"

namespace unibody {

// Sign of ((b - a) x (c - a)) . (d - a): 1 where d lies on the side that the normal of a, b, c points to, 0 in its plane.
int orient3d(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d);

// Whether the segment p q and the triangle a b c, ends and rims included, have a point in common. Holds for segments in the
// triangle's plane and for triangles and segments without area or length too.
bool edge_crosses_face(const Vec3& p, const Vec3& q, const Vec3& a, const Vec3& b, const Vec3& c);

}  // namespace unibody
