// Whether a point that goes along a straight line passes through the surface of a mesh, or into a convex solid. Pure functions of
// their arguments; lengths in m, in the frame of the mesh or the solid.
#pragma once

#include "collide/convex_distance.hpp"
#include "world/mesh_shape.hpp"

namespace unibody {

struct Passage {
  double share = 2;                      // of the way, at which the point gets to the surface; more than 1: it does not
  Vec3 normal = Vec3::Zero();            // unit, of the surface there, to the side from which the point comes
  double height_before = 0, height = 0;  // m, of the way's start and end over the plane through that place

  bool exists() const { return share <= 1; }
};

// A surface of one side is passed from its front alone. A point that goes along an edge or through a node is not missed.
Passage passage_through(const MeshSurface& mesh, const Vec3& from, const Vec3& to);

// A point that starts within the solid does not come into it.
Passage passage_into(const ConvexBody& solid, const Vec3& from, const Vec3& to);

// Where a point that goes from `from` to `to` has to end to have passed through nothing. `passage(from, to)` finds the first
// passage; what the point does along a surface is kept, and it ends `kept` (m) over it, or half as high as it was before if that
// is less. Where that leads from one surface into the next without an end it stays at `from`.
template <class Find>
Vec3 held_back(const Vec3& from, Vec3 to, double kept, Find&& passage) {
  constexpr int most = 16;
  for (int k = 0; k < most; ++k) {
    const Passage found = passage(from, to);
    if (!found.exists()) return to;
    to += (std::min(kept, 0.5 * found.height_before) - found.height) * found.normal;
  }
  return from;
}

}  // namespace unibody
