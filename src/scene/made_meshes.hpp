// Meshes that a scene describes by numbers.
#pragma once

#include "meshes/triangle_mesh.hpp"
#include "scene/key.hpp"

namespace unibody {

const Keys& height_field_keys();
const Keys& tube_keys();
const Keys& revolved_keys();

// {size, cells, and heights or hills and seed}: terrain about the origin. below: m, how far down it is solid at least.
TriangleMesh read_height_field(const Value& value, double& below);

// {radius, length, sides}: the side and both ends of a drum about z, facing its axis.
TriangleMesh read_tube(const Value& value);

// {profile: [[radius, height], ...] (m), sides}: what the line through these points covers when it turns about z, by so many flat
// sides, whose edges lie on the surface of revolution. Triangles are counterclockwise from outside where the heights ascend.
TriangleMesh read_revolved(const Value& value);

}  // namespace unibody
