// What cloths, threads and solids have in common (pins: pins.cpp).
#include "scene/flexible.hpp"

#include "scene/in_time.hpp"

namespace unibody {

Body Nodes::at(const Vec3& place, double mass) const {
  BodyTemplate own = particle;
  own.mass = mass;
  return make_body(own, particle.properties.shape, position + orientation * place);
}

Spring read_spring(const KeyedMap& map) { return {map.number_if("stiffness").value_or(0), map.number("damping")}; }

std::vector<Key> spring_keys(const char* unit, const char* of_what) {
  return {keys::number("stiffness", unit, positive, "stiff", of_what),
          keys::number("damping", "s", not_negative, 0, "rho: an error c is resisted as c + rho dc/dt")};
}

Keys node_keys(const char* name, const char* about, const char* pinned_node) {
  return {name,
          about,
          {name_key(), keys::vector("position", "m", "[0, 0, 0]", "where the origin of its frame is"),
           orientation_key("how its frame is turned"),
           keys::vector("velocity", "m/s", "[0, 0, 0]", "velocity of all nodes at the start"), material_key(),
           pins_key(pinned_node)}};
}

Key self_collision_key() { return keys::flag("self_collision", false, "it touches itself"); }
Key drag_key() {
  return keys::number("drag", "", not_negative, 0, "coefficient of the air's drag along the normals of the triangles; 0: none");
}

Key pressure_key(const char* about) { return keys::number_in_time("pressure", "Pa", any_number, 0, about); }

Nodes read_nodes(const KeyedMap& entry, double radius, const Scene& scene) {
  Nodes nodes;
  nodes.particle.properties.shape = {ShapeKind::particle, Vec3(radius, 0, 0)};
  nodes.particle.properties.group = static_cast<std::int32_t>(scene.constraint_groups.size());
  nodes.line = entry.value().line;
  if (const Value* name = entry.find("name")) nodes.name = name->string("a name");
  if (entry.has("position")) nodes.position = read_vector(entry, "position", scene);
  if (const Value* value = entry.find("orientation")) nodes.orientation = read_orientation(*value, scene);
  if (entry.has("velocity")) nodes.particle.velocity = read_vector(entry, "velocity", scene);
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

void add_surface(const KeyedMap& entry, Scene& scene, const std::string& name, Id first, const MeshShape& shape) {
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
  surface.self_collision = entry.flag("self_collision"), surface.drag = entry.number("drag");
  if (entry.has("pressure")) surface.pressure = read_in_time(entry, "pressure", scene);
}

}  // namespace unibody
