// Where a point is with regard to the surface of a mesh shape.
#pragma once

#include <vector>

#include "world/mesh_shape.hpp"

namespace unibody {

struct MeshPlace {
  Vec3 point;    // m, of the surface, nearest to the point asked about
  Vec3 normal;   // unit, outwards, of the face, edge or node on which it lies; 0 on a border
  double depth;  // m, the distance; negative in front of the surface
};

// Finds on which side of the mesh a point `x` (m, frame of the mesh) lies, by the sign of its way to the nearest point of the
// surface along the normal there (Baerentzen & Aanaes 2005). Returns false where that point is further than `limit` (m) or on a
// border, behind which there is no side, and for two-sided meshes.
bool find_place(const MeshSurface& mesh, const Vec3& x, double limit, MeshPlace& place);

// Whether `x` lies behind the mesh, no deeper than `limit`; if it does `place` is filled. Gives the same answer as find_place(),
// and sooner where many ask about places in front of a surface that has no border.
bool is_behind(const MeshSurface& mesh, const Vec3& x, double limit, MeshPlace& place);

// Selects, of the triangles `near` a body, those that its centre `x` (m, frame of the mesh) does not rule out, turned over
// where it is on their other side. All triangles in a patch of a two-sided mesh face the side on which the patch's nearest
// point sees the centre. A triangle is ruled out where the surface that goes on over its nearest edge hides it, as a floor
// hides a wall under it.
std::vector<MeshSurface::Triangle> facing(const MeshSurface& mesh, const std::vector<std::int32_t>& near, const Vec3& x);

}  // namespace unibody
