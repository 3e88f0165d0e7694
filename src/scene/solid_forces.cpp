// Loads of solids: forces spread over a part of the surface.
#include "scene/in_time.hpp"
#include "scene/solid_shape.hpp"

namespace unibody {

namespace {

constexpr double slack = 1e-9;  // of the part's extent: nodes on its rim belong to it

const Keys& part_keys() {
  static const Keys table{"within",
                          "A box along the world's axes.",
                          {keys::vector("min", "m", needed, "corner of the least coordinates"),
                           keys::vector("max", "m", needed, "corner of the greatest coordinates")}};
  return table;
}

const Keys& load_keys() {
  static const Keys table{
      "load",
      "A force on a part of a solid's surface.",
      {within_key(needed, "box, world axes: the triangles of the surface with all of their nodes in it at the start"),
       keys::vector_in_time("force", "N", needed,
                            "the force in all, spread by area, and from each triangle evenly to its nodes")}};
  return table;
}

}  // namespace

Key within_key(const Without& without, const char* about) {
  return keys::map("within", part_keys, "a map with min and max (m)", without, about);
}

Key loads_key() { return keys::list_of_maps("loads", load_keys, "loads", "none", "dead forces on parts of the surface"); }

bool Part::holds(const Vec3& x) const {
  const Vec3 room = Vec3::Constant(slack * (1 + (upper - lower).maxCoeff()));
  return ((x - lower + room).array() >= 0).all() && ((upper + room - x).array() >= 0).all();
}

Part read_part(const Value& value, const Scene& scene) {
  const KeyedMap map(value, part_keys());
  Part part;
  part.lower = read_vector(map, "min", scene);
  part.upper = read_vector(map, "max", scene);
  if (!((part.upper - part.lower).array() >= 0).all()) value.fail("max below min", "a box from min to max");
  return part;
}

// Spreads each force by area over the triangles that lie in the part with all of their nodes: a third of a triangle's share at
// each.
Loads read_loads(const KeyedMap& entry, const MeshShape& shape, const Nodes& nodes, const Scene& scene) {
  Loads loads;
  if (!entry.has("loads")) return loads;
  for (const Value& value : entry.list("loads")) {
    const KeyedMap map(value, load_keys());
    const Part part = read_part(map.need("within"), scene);
    const TimeVector force = read_planar_in_time(map, "force", scene, false);
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
    if (force.changes()) {
      PartLoad& load = loads.in_time.emplace_back();
      load.force = force;
      for (const auto& [node, share] : area) load.shares.emplace_back(node, share / total);
      continue;
    }
    for (const auto& [node, share] : area) {
      const auto at = loads.constant.try_emplace(node, Vec3::Zero()).first;
      at->second += share / total * force.at(0);
    }
  }
  return loads;
}

}  // namespace unibody
