// The triangles of a mesh to which a body comes within a step, one after the other.
//
// Each triangle that a fast body comes to turns it aside, so that it comes to the next: in a pipe it may pass several within a
// step. A contact with the first alone, as the body stands at the start of the step, would let it leave the pipe through the
// others. The way is that of a body which neither turns nor bounces and which nothing rubs.
#pragma once

#include <span>
#include <vector>

#include "collide/convex_distance.hpp"
#include "world/mesh_shape.hpp"

namespace unibody {

// A body and a mesh at the start of a step, in the mesh's frame.
struct MeshEncounter {
  const ConvexBody& body;  // with its centre at the origin
  double half_size;        // m, of the body
  Vec3 place, velocity;    // m, m/s, of the body's centre as the mesh sees it
  double step;             // s
};

// The velocity (m/s), in the frame of a mesh that turns (rad/s), of the straight way from where a body at `place` is to where it
// will be seen at the end of the step. `velocity`: against the mesh's centre. The way of a body that nothing holds is bent there.
Vec3 velocity_seen(const Vec3& place, const Vec3& velocity, const Vec3& turn, double step);

// In the order in which the body comes to them. `near`: those that it could reach.
std::vector<const MeshSurface::Triangle*> triangles_on_way(const MeshEncounter& encounter, const MeshSurface& mesh,
                                                           std::span<const MeshSurface::Triangle* const> near);

}  // namespace unibody
