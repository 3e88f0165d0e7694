// The section `solids`: what blocks and meshes read alike.
#include <cmath>

#include "meshes/weld.hpp"
#include "scene/solid_shape.hpp"
#include "scene/weld_key.hpp"

namespace unibody {

namespace {

constexpr double most_unlocked_ratio = 0.45;  // from here on a run says that its tetrahedra lock

const std::vector<std::string> elasticity_keys{"youngs_modulus", "poissons_ratio", "damping"};

// Reads the elasticity of a solid, or of a region in it. What a region does not say is as in the rest of the solid.
Elasticity read_elasticity(const Value& map, const Elasticity* rest) {
  Elasticity result = rest ? *rest : Elasticity{};
  const auto has = [&](const char* key) { return !rest || map.find(key); };
  if (has("youngs_modulus")) result.youngs_modulus = map.need("youngs_modulus", "a number > 0 (Pa)").number(positive, "Pa");
  if (has("poissons_ratio"))
    result.poissons_ratio = map.need("poissons_ratio", "a number in (-1, 0.5)").number({-1, 0.5, true, true}, "");
  if (const Value* damping = map.find("damping")) result.damping = damping->number(not_negative, "s");
  return result;
}

SolidLaw read_law(const Value& entry, const Scene& scene) {
  SolidLaw law;
  law.density = entry.need("density", "a number > 0 (kg/m^3)").number(positive, "kg/m^3");
  law.elasticity = read_elasticity(entry, nullptr);
  if (const Value* volume = entry.find("energy_volume"))
    law.energy_volume = static_cast<EnergyVolume>(volume->choice({"rest", "current"}));
  if (const Value* least = entry.find("least_volume")) law.least_volume = least->number({0, 1, true, true}, "");
  if (const Value* value = entry.find("position")) law.position = read_vector(*value, scene, "m");
  if (const Value* value = entry.find("orientation")) law.orientation = read_orientation(*value, scene);
  if (const Value* regions = entry.find("regions"))
    for (const Value& region : regions->list("regions")) {
      std::vector<std::string> keys = elasticity_keys;
      keys.emplace_back("within");
      region.map(keys);
      const Part part = read_part(region.need("within", "a map with min and max (m)"), scene);
      law.regions.emplace_back(part, read_elasticity(region, &law.elasticity));
    }
  return law;
}

MeshShape read_shape_of(const Value& entry, const SolidLaw& law, const Scene& scene) {
  const Value *block = entry.find("block"), *mesh = entry.find("mesh"), *scale = entry.find("scale");
  if (block && mesh) mesh->fail("a mesh beside a block", "only one of block and mesh");
  if (!block && !mesh) entry.fail_missing("block", "a map with size and cells, or mesh: a .msh or .vtu file");
  if (block && scale) scale->fail_expected("no such key beside a block");
  const double share = read_weld(entry, "mesh");
  return block ? block_solid(*block, law) : mesh_solid(*mesh, scale ? scale->number(positive, "") : 1, share, law, scene);
}

void read_solid(const Value& entry, Scene& scene) {
  entry.map(solid_keys());
  const double thickness = entry.need("thickness", "a number > 0 (m)").number(positive, "m");
  MeshShape shape = read_shape_of(entry, read_law(entry, scene), scene);
  const Value* block = entry.find("block");
  check_room(block ? *block->find("cells") : *entry.find("mesh"), scene, shape.count);
  shape.closed = true;
  if (!(shape.mass(0) > 0 && std::isfinite(shape.mass(0))))
    entry.need("density", "").fail_expected("a finite mass > 0 of each node");
  const Nodes nodes = read_nodes(entry, thickness / 2, scene);
  Vec3 spin = Vec3::Zero();
  if (const Value* value = entry.find("angular_velocity")) spin = read_vector(*value, scene, "rad/s");
  const auto loads = read_loads(entry, shape, nodes, scene);
  const Id first = add_flexible(
      scene, nodes, shape.count,
      [shape, nodes, spin, loads](Id k) {
        Body body = nodes.at(shape.place(k), shape.mass(k));
        body.state.velocity += spin.cross(body.state.position - nodes.position);
        if (const auto load = loads.find(k); load != loads.end()) body.properties.force = load->second;
        return body;
      },
      shape.touching, shape.patch);
  add_surface(entry, scene, nodes.name, first, shape);
  read_pins(entry, scene, first, shape.count, shape.number);
  if (!shape.note.empty()) scene.notes.push_back(shape.note);
  if (const Value& ratio = *entry.find("poissons_ratio"); ratio.number(any_number, "") > most_unlocked_ratio)
    scene.notes.push_back(
        ratio.key + ": found " + ratio.found() +
        ": linear tetrahedra of a material that is nearly incompressible are too stiff, in bending by a third with four "
        "cells across at 0.49 (scenes/README.md#solids has a table)");
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
  const Elasticity& elasticity = law.at(0.25 * (at[0] + at[1] + at[2] + at[3]));
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

std::vector<std::string> solid_keys() {
  std::vector<std::string> keys = node_keys;
  keys.insert(keys.end(), elasticity_keys.begin(), elasticity_keys.end());
  for (const char* key : {"block", "mesh", "scale", "weld", "density", "regions", "energy_volume", "least_volume", "thickness",
                          "angular_velocity", "loads", "self_collision", "drag"})
    keys.emplace_back(key);
  return keys;
}

void read_solids(const Value& list, Scene& scene) {
  if (scene.planar) list.fail("solids in a planar scene", "planar: false: a solid needs all three directions");
  for (const Value& entry : list.list("solids")) read_solid(entry, scene);
}

}  // namespace unibody
