// Writes the shapes of the library (hulls, compounds, meshes) into the file of frames, for programs that draw them.
#pragma once

#include <array>

#include "core/types.hpp"
#include "world/shapes.hpp"

namespace unibody {

// A hull's or a mesh's surface as triangles, in the body's axes (m).
struct ShapeSurface {
  std::vector<std::array<double, 3>> nodes;
  std::vector<std::array<std::int64_t, 3>> triangles;
};
ShapeSurface surface_of(ShapeKind kind, std::size_t number);

// A compound's parts, one a row: kind, place in the library, size (3, m), place (3, m) and turn (w, x, y, z) in the body's axes.
std::vector<std::array<double, 12>> part_rows(std::size_t compound);

}  // namespace unibody
