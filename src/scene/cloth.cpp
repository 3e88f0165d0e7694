// The section `cloths`: what grids and meshes read alike.
#include <cmath>

#include "meshes/weld.hpp"
#include "scene/cloth_shape.hpp"
#include "scene/mesh_keys.hpp"

namespace unibody {

namespace {

const Keys& link_keys() {
  static const Keys table = Keys{"links", "Links on the edges of a cloth.", spring_keys("N/m", "stiffness of each link")}.with(
      {"", "", {keys::choice("diagonals", {"both", "alternating", "none"}, "both", "links across the cells of a grid")}});
  return table;
}

const Keys& membrane_keys() {
  static const Keys table{"membrane",
                          "Triangles, a grid's with alternating diagonals, that resist stretch and shear.",
                          {keys::number("youngs_modulus", "Pa", positive, needed, "Young's modulus"),
                           keys::number("poissons_ratio", "", {-1, 1, true, true}, needed, "Poisson's ratio"),
                           keys::number("damping", "s", not_negative, 0, "rho: a strain e is resisted as e + rho de/dt")}};
  return table;
}

const Keys& area_keys() {
  static const Keys table{
      "area", "Triangles, a grid's with alternating diagonals, that resist a change of their area.",
      spring_keys("N/m", "k: a triangle of area A pulls with a tension of k (A - A0) / A0, A0 its area at rest")};
  return table;
}

const Keys& bending_keys() {
  static const Keys table = Keys{
      "bending",
      "The resistance of a cloth to folding.",
      {keys::choice(
          "model", {"links", "dihedral"}, "links",
          "links to the second neighbour along a grid's lines, or across the inner edges of a mesh; or the angles at "
          "the inner edges")}}.with({"", "", spring_keys("N/m or N m/rad", "stiffness of each link, or of each angle")});
  return table;
}

void read_mass(const KeyedMap& entry, ClothLaw& law) {
  entry.only_one_of({"mass", "mass_per_area"});
  law.by_area = entry.has("mass_per_area");
  if (!law.by_area && !entry.has("mass")) entry.value().fail_missing("mass", "a mass (kg) or a mass_per_area (kg/m^2)");
  law.mass = entry.number(law.by_area ? "mass_per_area" : "mass");
}

void read_links(const Value& value, bool grid, ClothLaw& law) {
  const KeyedMap map(value, link_keys());
  law.links = read_spring(map);
  if (!grid) map.none_of({"diagonals"}, "beside a mesh: its links are its edges");
  law.diagonals = static_cast<Diagonals>(map.choice("diagonals"));
}

void read_membrane(const Value& value, double thickness, ClothLaw& law) {
  const KeyedMap map(value, membrane_keys());
  law.membrane = Fabric{map.number("youngs_modulus"), map.number("poissons_ratio"), thickness, map.number("damping")};
}

// Refused where something else says already what a triangle's area is.
void read_area(const Value& value, bool grid, ClothLaw& law) {
  const KeyedMap map(value, area_keys());
  if (law.membrane) value.fail("area beside a membrane", "no such key: a membrane resists changes of area itself");
  const bool all_sides = !grid || law.diagonals != Diagonals::none;
  if (all_sides && law.links->stiffness == 0)
    value.fail("area beside stiff links on all sides of the triangles",
               grid ? "links with a stiffness (N/m) or with diagonals: none" : "links with a stiffness (N/m)");
  law.area = read_spring(map);
}

void read_bending(const Value& value, ClothLaw& law) {
  const KeyedMap map(value, bending_keys());
  law.bending = Bending{map.choice("model") == 1, read_spring(map)};
}

ClothLaw read_law(const KeyedMap& entry, double thickness) {
  ClothLaw law;
  read_mass(entry, law);
  entry.only_one_of({"links", "membrane"});
  const Value *links = entry.find("links"), *membrane = entry.find("membrane");
  if (links) read_links(*links, entry.has("grid"), law);
  if (membrane) read_membrane(*membrane, thickness, law);
  if (!links && !membrane) law.links = Spring{};
  if (const Value* area = entry.find("area")) read_area(*area, entry.has("grid"), law);
  if (const Value* bending = entry.find("bending")) read_bending(*bending, law);
  return law;
}

MeshShape read_shape_of(const KeyedMap& entry, const ClothLaw& law, const Scene& scene) {
  entry.only_one_of({"grid", "mesh"});
  const Value *grid = entry.find("grid"), *mesh = entry.find("mesh");
  if (!grid && !mesh)
    entry.value().fail_missing("grid", "a map with size and nodes, or mesh: an OBJ, STL, PLY, glTF or DAE file");
  if (grid) entry.none_of({"scale", "up"}, "beside a grid");
  const double share = read_weld(entry, "mesh");
  return grid ? grid_cloth(*grid, law) : mesh_cloth(*mesh, read_mesh_scale(entry), share, law, scene);
}

void check_node_mass(const KeyedMap& entry, const MeshShape& shape) {
  for (const char* key : {"mass", "mass_per_area"})
    if (const Value* amount = entry.find(key))
      if (!(shape.mass(0) > 0 && std::isfinite(shape.mass(0)))) amount->fail_expected("a finite mass > 0 of each node");
}

void read_cloth(const Value& value, Scene& scene) {
  const KeyedMap entry(value, cloth_keys());
  const double thickness = entry.number("thickness");
  const ClothLaw law = read_law(entry, thickness);
  const MeshShape shape = read_shape_of(entry, law, scene);
  const Value* grid = entry.find("grid");
  check_room(grid ? *grid->find("nodes") : *entry.find("mesh"), scene, shape.count);
  check_node_mass(entry, shape);
  const Nodes nodes = read_nodes(entry, thickness / 2, scene);
  const Id first = add_flexible(
      scene, nodes, shape.count, [shape, nodes](Id k) { return nodes.at(shape.place(k), shape.mass(k)); }, shape.touching,
      shape.patch);
  add_surface(entry, scene, nodes.name, first, shape);
  if (law.membrane)
    scene.surfaces.back().elasticity = [fabric = *law.membrane](Id) {
      return std::array<double, 2>{fabric.youngs_modulus, fabric.poissons_ratio};
    };
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

const Keys& cloth_keys() {
  static const Keys table =
      node_keys("cloth", "A cloth of particles and what lies between them.", "[i, j] of a grid or k of a mesh, from 0")
          .with(
              {"",
               "",
               {keys::map("grid", grid_keys, "a map with size and nodes", "a mesh", "a flat cloth"),
                keys::text("mesh", "an OBJ, STL, PLY, glTF or DAE file", "a grid",
                           "OBJ, STL, PLY, glTF or DAE file, its path from the scene's folder"),
                keys::scale(), keys::up(), keys::weld(),
                keys::number("mass", "kg", positive, "a mass_per_area", "mass of the whole, the same for each node"),
                keys::number("mass_per_area", "kg/m^2", positive, "a mass",
                             "mass by area: a node has its share of each cell or triangle at it"),
                keys::number("thickness", "m", positive, needed, "thickness in contact, and of a membrane"),
                keys::map("links", link_keys, "a map", "{}, without a membrane", "a link on each edge"),
                keys::map("membrane", membrane_keys, "a map", "none",
                          "triangles that resist stretch and shear; not beside links"),
                keys::map("area", area_keys, "a map", "none", "triangles that resist a change of their area, beside links"),
                keys::map("bending", bending_keys, "a map", "none", "resistance to folding"), self_collision_key(), drag_key(),
                pressure_key("pushes each triangle along its normal, to the side from which its corners are counterclockwise")}});
  return table;
}

void read_cloths(const Value& list, Scene& scene) {
  if (scene.planar) list.fail("cloths in a planar scene", "planar: false: a cloth needs all three directions");
  for (const Value& entry : list.list("cloths")) read_cloth(entry, scene);
}

}  // namespace unibody
