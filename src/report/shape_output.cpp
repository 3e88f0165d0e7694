#include "report/shape_output.hpp"

#include "world/shape_library.hpp"

namespace unibody {

ShapeSurface surface_of(ShapeKind kind, std::size_t number) {
  ShapeSurface s;
  const auto add = [&](const std::vector<Vec3>& nodes) {
    for (const Vec3& x : nodes) s.nodes.push_back({x[0], x[1], x[2]});
  };
  if (kind == ShapeKind::mesh) {
    const MeshSurface& mesh = shape_library().meshes[number];
    add(mesh.nodes);
    for (const auto& t : mesh.triangles) s.triangles.push_back({t.nodes[0], t.nodes[1], t.nodes[2]});
    return s;
  }
  const Hull& hull = shape_library().hulls[number];
  add(hull.corners);
  for (const Hull::Face& f : hull.faces)
    for (std::uint32_t k = 1; k + 1 < f.count; ++k)
      s.triangles.push_back({hull.face_corners[f.first], hull.face_corners[f.first + k], hull.face_corners[f.first + k + 1]});
  return s;
}

std::vector<std::array<double, 12>> part_rows(std::size_t compound) {
  std::vector<std::array<double, 12>> rows;
  for (const Compound::Part& p : shape_library().compounds[compound].parts)
    rows.push_back({static_cast<double>(p.shape.kind), static_cast<double>(p.shape.data), p.shape.size[0], p.shape.size[1],
                    p.shape.size[2], p.place[0], p.place[1], p.place[2], p.turn.w(), p.turn.x(), p.turn.y(), p.turn.z()});
  return rows;
}

}  // namespace unibody
