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

// Of a point `x` (m, frame of the mesh), by the sign of its way to the nearest point of the surface along the normal there
// (Baerentzen & Aanaes 2005). False where that is further than `limit` (m) or on a border, behind which there is no side, and of
// two-sided meshes.
bool find_place(const MeshSurface& mesh, const Vec3& x, double limit, MeshPlace& place);

// Of the triangles `near` a body those that its centre `x` (m, frame of the mesh) does not rule out, turned over where it is on
// their other side. All of a patch of a two-sided mesh are on one side: on that of the patch's nearest point. Ruled out is what a
// surface that goes on over the triangle's nearest edge hides: a wall under a floor.
std::vector<MeshSurface::Triangle> facing(const MeshSurface& mesh, const std::vector<std::int32_t>& near, const Vec3& x);

}  // namespace unibody
