// What cloths, threads and solids have in common (pins: pins.cpp).
#include "scene/flexible.hpp"

namespace unibody {

Body Nodes::at(const Vec3& place, double mass) const {
  BodyTemplate own = particle;
  own.mass = mass;
  return make_body(own, particle.properties.shape, position + orientation * place);
}

Spring read_spring(const Value& map, const std::string& unit) {
  Spring spring;
  if (const Value* stiffness = map.find("stiffness")) spring.stiffness = stiffness->number(positive, unit);
  if (const Value* damping = map.find("damping")) spring.damping = damping->number(not_negative, "s");
  return spring;
}

Nodes read_nodes(const Value& entry, double radius, const Scene& scene) {
  Nodes nodes;
  nodes.particle.properties.shape = {ShapeKind::particle, Vec3(radius, 0, 0)};
  nodes.particle.properties.group = static_cast<std::int32_t>(scene.constraint_groups.size());
  nodes.line = entry.line;
  if (const Value* name = entry.find("name")) nodes.name = name->string("a name");
  if (const Value* value = entry.find("position")) nodes.position = read_vector(*value, scene, "m");
  if (const Value* value = entry.find("orientation")) nodes.orientation = read_orientation(*value, scene);
  if (const Value* value = entry.find("velocity")) nodes.particle.velocity = read_vector(*value, scene, "m/s");
  if (const Value* value = entry.find("material"))
    nodes.particle.properties.material = static_cast<std::int32_t>(value->choice(scene.materials));
  return nodes;
}

Id add_flexible(Scene& scene, const Nodes& nodes, Id count, std::function<Body(Id)> make,
                std::function<void(Id first, Id node, ConstraintSet& out)> touching, std::function<Id(Id)> patch) {
  const Id first = scene.body_count();
  BodyGroup group;
  group.first = first, group.count = count, group.rotates = false, group.name = nodes.name, group.line = nodes.line;
  group.make = [first, make = std::move(make)](Id k) {
    Body body = make(k);
    body.id = first + k;
    return body;
  };
  scene.groups.push_back(std::move(group));
  scene.constraint_groups.push_back(
      {first, count, [first, touching = std::move(touching)](Id id, ConstraintSet& out) { touching(first, id - first, out); },
       [first, patch = std::move(patch)](Id id) { return patch(id - first); }});
  return first;
}

void add_surface(const Value& entry, Scene& scene, const std::string& name, Id first, const MeshShape& shape) {
  Surface& surface = scene.surfaces.emplace_back();
  surface.name = name, surface.count = shape.triangle_count;
  surface.cell = [first, triangle = shape.triangle](Id t) {
    auto ids = triangle(t);
    for (Id& id : ids) id += first;
    return ids;
  };
  surface.first_node = first, surface.node_count = shape.count;
  surface.cells_of = [first, triangles_of = shape.triangles_of](Id node, std::vector<std::array<Id, 3>>& out) {
    const std::size_t begin = out.size();
    triangles_of(node - first, out);
    for (std::size_t k = begin; k < out.size(); ++k)
      for (Id& id : out[k]) id += first;
  };
  surface.closed = shape.closed;
  surface.tetrahedron_count = shape.tetrahedron_count;
  surface.tetrahedron = [first, tetrahedron = shape.tetrahedron](Id t) {
    auto ids = tetrahedron(t);
    for (Id& id : ids) id += first;
    return ids;
  };
  if (const Value* self = entry.find("self_collision")) surface.self_collision = self->boolean();
  if (const Value* drag = entry.find("drag")) surface.drag = drag->number(not_negative, "");
}

}  // namespace unibody
