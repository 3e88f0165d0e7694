// A convex solid on the triangles of a mesh shape.
#pragma once

#include "collide/convex_distance.hpp"
#include "collide/narrowphase.hpp"
#include "world/mesh_shape.hpp"

namespace unibody {

// One triangle in place, and what stands around it.
struct MeshTriangle {
  std::array<Vec3, 3> nodes;
  std::array<Vec3, 3> across;  // the corner behind each edge
  const MeshShape::Triangle* of;
  Vec3 normal;
};

// A body whose centre has gone through is pushed back from no deeper than this times its smallest size.
constexpr double deepest_behind = 3;

// Normal and points of contact, none further apart than `margin` (m), at most PairManifold::capacity. A triangle pushes outwards
// only, and at an edge or node only in directions that lie between its own and its neighbours': a solid that slides over a flat
// surface does not feel its edges. False where there are none.
bool triangle_manifold(const ConvexBody& body, const MeshTriangle& triangle, double margin, PairManifold& out);

// The same of a triangle with two sides: it pushes to the one where the body's centre is.
bool sheet_manifold(const ConvexBody& body, const std::array<Vec3, 3>& triangle, double margin, PairManifold& out);

}  // namespace unibody
