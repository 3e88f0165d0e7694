// The section `solids`: what blocks and meshes read alike.
#include <cmath>

#include "meshes/weld.hpp"
#include "scene/mesh_keys.hpp"
#include "scene/solid_shape.hpp"

namespace unibody {

namespace {

constexpr double most_unlocked_ratio = 0.45;  // from here on a run says that its tetrahedra lock

std::vector<Key> elasticity_keys(bool of_all) {
  const auto without = [of_all](const Without& what) { return of_all ? what : Without("as in the rest"); };
  return {keys::number("youngs_modulus", "Pa", positive, without(needed), "Young's modulus"),
          keys::number("poissons_ratio", "", {-1, 0.5, true, true}, without(needed), "Poisson's ratio"),
          keys::number("damping", "s", not_negative, without(0), "rho: a strain e is resisted as e + rho de/dt")};
}

const Keys& region_keys() {
  static const Keys table = Keys{"region",
                                 "A part of a solid of another elasticity.",
                                 {within_key(needed, "box, world axes, that holds a tetrahedron's centroid at the start")}}
                                .with({"", "", elasticity_keys(false)});
  return table;
}

// Reads the elasticity of a solid, or of a region in it. What a region does not say is as in the rest of the solid.
Elasticity read_elasticity(const KeyedMap& map, const Elasticity* rest) {
  const auto read = [&](const char* name, double Elasticity::*member) {
    return rest && !map.has(name) ? rest->*member : map.number(name);
  };
  return {read("youngs_modulus", &Elasticity::youngs_modulus), read("poissons_ratio", &Elasticity::poissons_ratio),
          read("damping", &Elasticity::damping)};
}

SolidLaw read_law(const KeyedMap& entry, const Scene& scene) {
  SolidLaw law;
  law.density = entry.number("density");
  law.elasticity = read_elasticity(entry, nullptr);
  law.energy_volume = static_cast<EnergyVolume>(entry.choice("energy_volume"));
  law.least_volume = entry.number_if("least_volume");
  if (entry.has("position")) law.position = read_vector(entry, "position", scene);
  if (const Value* value = entry.find("orientation")) law.orientation = read_orientation(*value, scene);
  if (!entry.has("regions")) return law;
  for (const Value& region : entry.list("regions")) {
    const KeyedMap map(region, region_keys());
    const Part part = read_part(map.need("within"), scene);
    law.regions.emplace_back(part, read_elasticity(map, &law.elasticity));
  }
  return law;
}

Vec3 centroid(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) { return 0.25 * (a + b + c + d); }

MeshShape read_shape_of(const KeyedMap& entry, const SolidLaw& law, const Scene& scene) {
  entry.only_one_of({"block", "mesh"});
  const Value *block = entry.find("block"), *mesh = entry.find("mesh");
  if (!block && !mesh) entry.value().fail_missing("block", "a map with size and cells, or mesh: a .msh or .vtu file");
  if (block) entry.none_of({"scale", "up"}, "beside a block");
  const double share = read_weld(entry, "mesh");
  return block ? block_solid(*block, law) : mesh_solid(*mesh, read_mesh_scale(entry), share, law, scene);
}

void read_solid(const Value& value, Scene& scene) {
  const KeyedMap entry(value, solid_keys());
  const double thickness = entry.number("thickness");
  const SolidLaw law = read_law(entry, scene);
  MeshShape shape = read_shape_of(entry, law, scene);
  const Value* block = entry.find("block");
  check_room(block ? *block->find("cells") : *entry.find("mesh"), scene, shape.count);
  shape.closed = true;
  if (!(shape.mass(0) > 0 && std::isfinite(shape.mass(0)))) entry.need("density").fail_expected("a finite mass > 0 of each node");
  const Nodes nodes = read_nodes(entry, thickness / 2, scene);
  Vec3 spin = Vec3::Zero();
  if (entry.has("angular_velocity")) spin = read_vector(entry, "angular_velocity", scene);
  const Loads loads = read_loads(entry, shape, nodes, scene);
  const Id first = add_flexible(
      scene, nodes, shape.count,
      [shape, nodes, spin, constant = loads.constant](Id k) {
        Body body = nodes.at(shape.place(k), shape.mass(k));
        body.state.velocity += spin.cross(body.state.position - nodes.position);
        if (const auto load = constant.find(k); load != constant.end()) body.properties.force = load->second;
        return body;
      },
      shape.touching, shape.patch);
  for (PartLoad load : loads.in_time) {
    for (auto& [node, share] : load.shares) node += first;
    scene.part_loads.push_back(std::move(load));
  }
  add_surface(entry, scene, nodes.name, first, shape);
  scene.surfaces.back().elasticity = [law, shape](Id k) {
    const auto corners = shape.tetrahedron(k);
    const Elasticity& elasticity =
        law.at(centroid(shape.place(corners[0]), shape.place(corners[1]), shape.place(corners[2]), shape.place(corners[3])));
    return std::array<double, 2>{elasticity.youngs_modulus, elasticity.poissons_ratio};
  };
  scene.surfaces.back().energy_volume = law.energy_volume == EnergyVolume::current ? "current" : "rest";
  read_pins(entry, scene, first, shape.count, shape.number);
  if (!shape.note.empty()) scene.notes.push_back(shape.note);
  if (const Value& ratio = *entry.find("poissons_ratio"); ratio.number(any_number, "") > most_unlocked_ratio)
    scene.notes.push_back(
        ratio.key + ": found " + ratio.found() +
        ": linear tetrahedra of a material that is nearly incompressible are too stiff, in bending by a third with four "
        "cells across at 0.49 (docs/scene-flexible.md#solids has a table)");
}

}  // namespace

const Elasticity& SolidLaw::at(const Vec3& place) const {
  const Vec3 world = position + orientation * place;
  for (auto region = regions.rbegin(); region != regions.rend(); ++region)
    if (region->first.holds(world)) return region->second;
  return elasticity;
}

void add_tetrahedron(const SolidLaw& law, const std::array<Vec3, 4>& at, const std::array<Id, 4>& ids, std::int32_t colour,
                     ConstraintSet& out) {
  const auto parameters = Tetrahedron::at_rest(at[0], at[1], at[2], at[3]);
  const double length = parameters[9], volume = length * length * length / 6;
  const Elasticity& elasticity = law.at(centroid(at[0], at[1], at[2], at[3]));
  const auto add = [&](auto& list) {
    auto& c = list.emplace_back();
    c.ids = ids, c.colour = colour, c.parameters = parameters;
    c.compliance = Tetrahedron::compliance(elasticity.youngs_modulus, elasticity.poissons_ratio, volume, length);
    c.damping = elasticity.damping;
  };
  if (law.energy_volume == EnergyVolume::current)
    add(std::get<ConstraintList<TetrahedronCurrentVolume>>(out));
  else
    add(std::get<ConstraintList<Tetrahedron>>(out));
  if (!law.least_volume) return;
  Constraint<InversionGuard> guard;
  guard.ids = ids, guard.colour = colour;
  guard.parameters = {6 * volume, *law.least_volume, length};
  std::get<ConstraintList<InversionGuard>>(out).push_back(guard);
}

const Keys& solid_keys() {
  static const Keys table =
      node_keys("solid", "A soft solid of tetrahedra.", "[i, j, k] of a block or k of a mesh, from 0")
          .with(
              {"",
               "",
               {keys::map("block", block_keys, "a map with size and cells", "a mesh", "a block of tetrahedra"),
                keys::text("mesh", "a .msh or .vtu file", "a block",
                           "Gmsh (2.2, 4.1) or VTK file of tetrahedra, its path from the scene's folder"),
                keys::scale(), keys::up(), keys::weld(), keys::number("density", "kg/m^3", positive, needed, "density at rest")}})
          .with({"", "", elasticity_keys(true)})
          .with({"",
                 "",
                 {keys::list_of_maps("regions", region_keys, "regions", "none",
                                     "parts of another elasticity; where they overlap the last holds"),
                  keys::choice(
                      "energy_volume", {"rest", "current"}, "rest",
                      "the volume of a tetrahedron that weighs its strains' energy: that at rest, as St. Venant-Kirchhoff; or "
                      "its current one, as the paper"),
                  keys::number("least_volume", "", {0, 1, true, true}, "none",
                               "share of its volume at rest below which a tetrahedron is kept from falling"),
                  keys::number("thickness", "m", positive, needed,
                               "of its skin: what touches it lies at half of that from its surface"),
                  keys::vector("angular_velocity", "rad/s", "[0, 0, 0]", "angular velocity at the start, about the position"),
                  loads_key(), self_collision_key(), drag_key(),
                  pressure_key("pushes each triangle of the surface outwards; negative: inwards")}});
  return table;
}

void read_solids(const Value& list, Scene& scene) {
  if (scene.planar) list.fail("solids in a planar scene", "planar: false: a solid needs all three directions");
  for (const Value& entry : list.list("solids")) read_solid(entry, scene);
}

}  // namespace unibody
