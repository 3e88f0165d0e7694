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
  const MeshSurface::Triangle* of;
  Vec3 normal;
  const MeshSurface* mesh;
  Vec3 origin;  // m, in the mesh's frame: from which the nodes are
};

// Normal and points of contact, none further apart than `margin` (m), at most PairManifold::capacity. A triangle pushes outwards
// only, bodies whose centre is on its outer side, and at an edge or node only in directions that lie between its own and its
// neighbours': a solid that slides over a flat surface does not feel its edges. False where there are none.
bool triangle_manifold(const ConvexBody& body, const MeshTriangle& triangle, double margin, PairManifold& out);

// Whether a body is apart from a triangle, by at most the margin (m), and none of its neighbours is nearer; the nearest points.
bool has_no_nearer_neighbour(const ConvexBody& body, const MeshTriangle& triangle, double margin, ConvexDistance& nearest);

// The same on the half space behind a plane: the corners that the solid turns to it, and its lowest point.
bool half_space_manifold(const ConvexBody& body, const Vec3& on_plane, const Vec3& normal, double margin, PairManifold& out);

// The same of a triangle with two sides: it pushes to the one where the body's centre is.
bool sheet_manifold(const ConvexBody& body, const std::array<Vec3, 3>& triangle, double margin, PairManifold& out);

}  // namespace unibody
