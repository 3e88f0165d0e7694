#include "world/shape_library.hpp"

namespace unibody {

Shape ShapeLibrary::add(Hull hull) {
  std::size_t k = 0;
  while (k < hulls.size() && !(hulls[k].corners == hull.corners && hulls[k].frame.coeffs() == hull.frame.coeffs())) ++k;
  if (k == hulls.size()) hulls.push_back(std::move(hull));
  return {ShapeKind::hull, hulls[k].size, static_cast<std::uint32_t>(k)};
}

Shape ShapeLibrary::add(Compound compound) {
  compounds.push_back(std::move(compound));
  return {ShapeKind::compound, compounds.back().size, static_cast<std::uint32_t>(compounds.size() - 1)};
}

Shape ShapeLibrary::add(MeshSurface mesh) {
  meshes.push_back(std::move(mesh));
  return {ShapeKind::mesh, meshes.back().size, static_cast<std::uint32_t>(meshes.size() - 1)};
}

std::size_t ShapeLibrary::count(ShapeKind kind) const {
  if (kind == ShapeKind::hull) return hulls.size();
  if (kind == ShapeKind::compound) return compounds.size();
  return kind == ShapeKind::mesh ? meshes.size() : 1;
}

ShapeLibrary& shape_library() {
  static ShapeLibrary library;
  return library;
}

}  // namespace unibody
