// Loads of solids: forces spread over a part of the surface.
#include "scene/solid_shape.hpp"

namespace unibody {

namespace {

constexpr double slack = 1e-9;  // of the part's extent: nodes on its rim belong to it

}  // namespace

bool Part::holds(const Vec3& x) const {
  const Vec3 room = Vec3::Constant(slack * (1 + (upper - lower).maxCoeff()));
  return ((x - lower + room).array() >= 0).all() && ((upper + room - x).array() >= 0).all();
}

Part read_part(const Value& value, const Scene& scene) {
  value.map({"min", "max"});
  Part part;
  part.lower = read_vector(value.need("min", "a point (m)"), scene, "m");
  part.upper = read_vector(value.need("max", "a point (m)"), scene, "m");
  if (!((part.upper - part.lower).array() >= 0).all()) value.fail("max below min", "a box from min to max");
  return part;
}

// Spreads each force by area over the triangles that lie in the part with all of their nodes: a third of a triangle's share at
// each.
std::map<Id, Vec3> read_loads(const Value& entry, const MeshShape& shape, const Nodes& nodes, const Scene& scene) {
  std::map<Id, Vec3> loads;
  const Value* list = entry.find("loads");
  if (!list) return loads;
  for (const Value& value : list->list("loads")) {
    value.map({"within", "force"});
    const Part part = read_part(value.need("within", "a map with min and max (m)"), scene);
    const Vec3 force = read_vector(value.need("force", "a vector (N)"), scene, "N");
    std::map<Id, double> area;
    double total = 0;
    for (Id t = 0; t < shape.triangle_count; ++t) {
      const auto n = shape.triangle(t);
      std::array<Vec3, 3> x;
      bool inside = true;
      for (std::size_t k = 0; k < 3; ++k)
        x[k] = nodes.at(shape.place(n[k]), 1).state.position, inside = inside && part.holds(x[k]);
      if (!inside) continue;
      const double share = (x[1] - x[0]).cross(x[2] - x[0]).norm() / 6;
      for (const Id node : n) area[node] += share, total += share;
    }
    if (!(total > 0)) value.fail("a part without a triangle of the surface", "a box (m, world axes) with some in it");
    for (const auto& [node, share] : area) {
      const auto at = loads.try_emplace(node, Vec3::Zero()).first;
      at->second += share / total * force;
    }
  }
  return loads;
}

}  // namespace unibody
