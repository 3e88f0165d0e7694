// The section `cloths`: what grids and meshes read alike.
#include <cmath>

#include "meshes/weld.hpp"
#include "scene/cloth_shape.hpp"
#include "scene/weld_key.hpp"

namespace unibody {

namespace {

void read_mass(const Value& entry, ClothLaw& law) {
  const Value *mass = entry.find("mass"), *per_area = entry.find("mass_per_area");
  if (mass && per_area) per_area->fail(per_area->found() + " beside mass " + mass->found(), "only one of mass and mass_per_area");
  if (!mass && !per_area) entry.fail_missing("mass", "a mass (kg) or a mass_per_area (kg/m^2)");
  law.by_area = per_area != nullptr;
  law.mass = mass ? mass->number(positive, "kg") : per_area->number(positive, "kg/m^2");
}

void read_links(const Value& value, bool grid, ClothLaw& law) {
  value.map({"diagonals", "stiffness", "damping"});
  law.links = read_spring(value, "N/m");
  const Value* diagonals = value.find("diagonals");
  if (!diagonals) return;
  if (!grid) diagonals->fail_expected("no such key beside a mesh: its links are its edges");
  law.diagonals = static_cast<Diagonals>(diagonals->choice({"both", "alternating", "none"}));
}

void read_membrane(const Value& value, double thickness, ClothLaw& law) {
  value.map({"youngs_modulus", "poissons_ratio", "damping"});
  Fabric fabric;
  fabric.youngs_modulus = value.need("youngs_modulus", "a number > 0 (Pa)").number(positive, "Pa");
  fabric.poissons_ratio = value.need("poissons_ratio", "a number in (-1, 1)").number({-1, 1, true, true}, "");
  fabric.thickness = thickness;
  if (const Value* damping = value.find("damping")) fabric.damping = damping->number(not_negative, "s");
  law.membrane = fabric;
}

// Refused where something else says already what a triangle's area is.
void read_area(const Value& value, bool grid, ClothLaw& law) {
  value.map({"stiffness", "damping"});
  if (law.membrane) value.fail("area beside a membrane", "no such key: a membrane resists changes of area itself");
  const bool all_sides = !grid || law.diagonals != Diagonals::none;
  if (all_sides && law.links->stiffness == 0)
    value.fail("area beside stiff links on all sides of the triangles",
               grid ? "links with a stiffness (N/m) or with diagonals: none" : "links with a stiffness (N/m)");
  law.area = read_spring(value, "N/m");
}

void read_bending(const Value& value, ClothLaw& law) {
  value.map({"model", "stiffness", "damping"});
  Bending bending;
  if (const Value* model = value.find("model")) bending.dihedral = model->choice({"links", "dihedral"}) == 1;
  bending.spring = read_spring(value, bending.dihedral ? "N m/rad" : "N/m");
  law.bending = bending;
}

ClothLaw read_law(const Value& entry, double thickness) {
  ClothLaw law;
  read_mass(entry, law);
  const Value *links = entry.find("links"), *membrane = entry.find("membrane"), *bending = entry.find("bending");
  if (links && membrane) membrane->fail("a membrane beside links", "only one of links and membrane");
  if (links) read_links(*links, entry.find("grid") != nullptr, law);
  if (membrane) read_membrane(*membrane, thickness, law);
  if (!links && !membrane) law.links = Spring{};
  if (const Value* area = entry.find("area")) read_area(*area, entry.find("grid") != nullptr, law);
  if (bending) read_bending(*bending, law);
  return law;
}

MeshShape read_shape_of(const Value& entry, const ClothLaw& law, const Scene& scene) {
  const Value *grid = entry.find("grid"), *mesh = entry.find("mesh"), *scale = entry.find("scale");
  if (grid && mesh) mesh->fail("a mesh beside a grid", "only one of grid and mesh");
  if (!grid && !mesh) entry.fail_missing("grid", "a map with size and nodes, or mesh: an OBJ or STL file");
  if (grid && scale) scale->fail_expected("no such key beside a grid");
  const double share = read_weld(entry, "mesh");
  return grid ? grid_cloth(*grid, law) : mesh_cloth(*mesh, scale ? scale->number(positive, "") : 1, share, law, scene);
}

void check_node_mass(const Value& entry, const MeshShape& shape) {
  for (const char* key : {"mass", "mass_per_area"})
    if (const Value* amount = entry.find(key))
      if (!(shape.mass(0) > 0 && std::isfinite(shape.mass(0)))) amount->fail_expected("a finite mass > 0 of each node");
}

void read_cloth(const Value& entry, Scene& scene) {
  entry.map(cloth_keys());
  const double thickness = entry.need("thickness", "a number > 0 (m)").number(positive, "m");
  const MeshShape shape = read_shape_of(entry, read_law(entry, thickness), scene);
  const Value* grid = entry.find("grid");
  check_room(grid ? *grid->find("nodes") : *entry.find("mesh"), scene, shape.count);
  check_node_mass(entry, shape);
  const Nodes nodes = read_nodes(entry, thickness / 2, scene);
  const Id first = add_flexible(
      scene, nodes, shape.count, [shape, nodes](Id k) { return nodes.at(shape.place(k), shape.mass(k)); }, shape.touching,
      shape.patch);
  add_surface(entry, scene, nodes.name, first, shape);
  read_pins(entry, scene, first, shape.count, shape.number);
  if (!shape.note.empty()) scene.notes.push_back(shape.note);
}

}  // namespace

Constraint<Membrane> membrane_at_rest(const Fabric& fabric, const Vec3& a, const Vec3& b, const Vec3& c) {
  Constraint<Membrane> result;
  result.parameters = Membrane::at_rest(a, b, c);
  const double area = 0.5 * (b - a).cross(c - a).norm();
  result.compliance =
      Membrane::compliance(fabric.youngs_modulus, fabric.poissons_ratio, area, fabric.thickness, result.parameters[3]);
  result.damping = fabric.damping;
  return result;
}

// The length is the root of the rest area: then the energy c^2 / 2E is that of a tension k (A - A0) / A0 with E = 1 / k.
Constraint<Area> area_at_rest(const Spring& spring, const Vec3& a, const Vec3& b, const Vec3& c) {
  Constraint<Area> result;
  const double area = 0.5 * (b - a).cross(c - a).norm();
  result.parameters = {area, std::sqrt(area)};
  result.compliance = {spring.compliance()}, result.damping = spring.damping;
  return result;
}

Constraint<Dihedral> angle_at_rest(const Spring& spring, double angle, double length) {
  Constraint<Dihedral> result;
  result.parameters = {angle, length};
  result.compliance = {length * length * spring.compliance()}, result.damping = spring.damping;
  return result;
}

std::vector<std::string> cloth_keys() {
  std::vector<std::string> keys = node_keys;
  for (const char* key : {"grid", "mesh", "scale", "weld", "mass", "mass_per_area", "thickness", "links", "membrane", "area",
                          "bending", "self_collision", "drag"})
    keys.emplace_back(key);
  return keys;
}

void read_cloths(const Value& list, Scene& scene) {
  if (scene.planar) list.fail("cloths in a planar scene", "planar: false: a cloth needs all three directions");
  for (const Value& entry : list.list("cloths")) read_cloth(entry, scene);
}

}  // namespace unibody
