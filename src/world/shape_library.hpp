// Shapes that need more data than a body carries. Bodies refer to them by number (Shape::data).
//
// The library is the same on every rank: all read the same scene, and add the same shapes in the same order. It only grows.
#pragma once

#include <deque>

#include "world/compound.hpp"
#include "world/hull.hpp"
#include "world/mesh_shape.hpp"

namespace unibody {

struct ShapeLibrary {
  std::deque<Hull> hulls;
  std::deque<Compound> compounds;
  std::deque<MeshSurface> meshes;

  // Each returns the shape; the same hull twice is one.
  Shape add(Hull hull);
  Shape add(Compound compound);
  Shape add(MeshSurface mesh);
  std::size_t count(ShapeKind kind) const;  // of the kinds that are here; else 1
};

ShapeLibrary& shape_library();

}  // namespace unibody
