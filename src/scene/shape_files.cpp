#include "scene/shape_files.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <stdexcept>

#include "meshes/convex_pieces.hpp"
#include "meshes/mesh_holes.hpp"
#include "meshes/mesh_topology.hpp"
#include "meshes/surface_file.hpp"
#include "meshes/triangle_soup.hpp"
#include "meshes/weld.hpp"
#include "scene/body_entry.hpp"
#include "scene/made_meshes.hpp"
#include "scene/mesh_keys.hpp"
#include "scene/shape_entry.hpp"
#include "world/compound_mass.hpp"
#include "world/shape_library.hpp"
#include "world/shape_type.hpp"

namespace unibody {

namespace {

// A mesh from the key `key`, by `scale` and `up`.
TriangleMesh read_mesh(const KeyedMap& map, const char* key, const Scene& scene, std::string& path, bool soup = false) {
  path = surface_path(map.need(key), scene);
  TriangleMesh mesh = read_surface(path, soup);
  read_mesh_scale(map).apply(mesh.nodes);
  return mesh;
}

Shape add_hull(const Value& value, const std::vector<Vec3>& points) {
  try {
    return shape_library().add(make_hull(points));
  } catch (const std::invalid_argument& fault) {
    value.fail(fault.what(), "points that span a solid");
  }
}

// A surface without holes, its triangles facing outwards.
SolidMoments check_closed(TriangleMesh& mesh, const Value& value, const std::string& path) {
  const MeshTopology topology = mesh_topology(mesh, path);
  if (!topology.boundary.empty()) {
    const auto& edge = topology.edges[static_cast<std::size_t>(topology.boundary[0])].nodes;
    value.fail("a mesh with a hole: the edge between nodes " + std::to_string(edge[0]) + " and " + std::to_string(edge[1]) +
                   " (numbered from 0) has one triangle",
               "a closed surface");
  }
  orient_triangles(mesh, topology, path);
  SolidMoments moments = solid_moments(mesh.nodes, mesh.triangles);
  if (moments.volume < 0) {
    for (auto& t : mesh.triangles) std::swap(t[1], t[2]);
    moments = solid_moments(mesh.nodes, mesh.triangles);
  }
  if (!(moments.volume > 0 && moments.inertia.minCoeff() > 0))
    value.fail("a mesh without volume", "a closed surface around a solid");
  return moments;
}

const Keys& compound_part_keys() {
  static const Keys table{
      "compound_part",
      "A convex shape of a compound.",
      {shape_key(needed), keys::vector("position", "m", "[0, 0, 0]", "where it is in the compound's axes"),
       keys::number("density", "kg/m^3", positive, "that of the body", "its density; with one part all have theirs"),
       orientation_key("how it is turned in the compound's axes")}};
  return table;
}

Compound::Part read_compound_part(const Value& value, const Scene& scene) {
  const KeyedMap map(value, compound_part_keys());
  Compound::Part part{{}, Vec3::Zero(), Quat::Identity()};
  const Value& shape = map.need("shape");
  part.shape = read_shape(shape, scene);
  if (!type_of(part.shape.kind).convex) shape.fail("a " + shape.children[0].first + " in a compound", "a convex solid");
  if (map.has("position")) part.place = read_vector(map, "position", scene);
  if (const Value* turn = map.find("orientation")) part.turn = read_orientation(*turn, scene);
  return part;
}

// kg/m^3, of each part; empty where none has one.
std::vector<double> read_densities(const Value& list) {
  std::vector<double> densities;
  for (const Value& part : list.entries)
    if (const auto density = KeyedMap(part, compound_part_keys()).number_if("density")) densities.push_back(*density);
  if (densities.empty() || densities.size() == list.entries.size()) return densities;
  const auto without = [](const Value& part) { return part.find("density") == nullptr; };
  std::ranges::find_if(list.entries, without)->fail_missing("density", "a density (kg/m^3), since other parts have one");
}

// Where a mesh comes from that has no file.
std::string place_of(const Value& value) {
  return *value.origin + (value.line > 0 ? ":" + std::to_string(value.line) : "") + ": key '" + value.key + "'";
}

std::string describe(const std::vector<Hole>& holes) {
  const Hole& widest = holes.front();
  std::array<char, 160> text{};
  std::snprintf(text.data(), text.size(), "%.3g m wide, at [%.3g, %.3g, %.3g] m from the mesh's origin", widest.width,
                widest.centre.x(), widest.centre.y(), widest.centre.z());
  const std::string which = holes.size() == 1 ? "a hole, " : std::to_string(holes.size()) + " holes, the widest ";
  return "it has " + which + text.data() + ": bodies may pass through";
}

// What a person should know of a mesh: what was mended in it, and its holes. Empty where there is nothing to tell.
std::string describe(const SoupFaults& faults, bool two_sided, const std::vector<Hole>& holes) {
  std::string text;
  const auto add = [&](std::int64_t count, const std::string& what) {
    if (count > 0)
      text += (text.empty() ? "left out " : " and ") + std::to_string(count) + (count == 1 ? " triangle " : " triangles ") + what;
  };
  add(faults.without_area, "without area"), add(faults.repeated, "given before");
  if (faults.welded > 0)
    text += (text.empty() ? "" : "; ") + std::to_string(faults.welded) +
            " of its nodes welded to others at the same place (weld: 0 keeps them apart)";
  if (two_sided)
    text += std::string(text.empty() ? "" : "; ") + "its triangles do not agree which side is out: touched from both";
  if (!holes.empty()) text += (text.empty() ? "" : "; ") + describe(holes);
  return text;
}

// From which side a surface is touched; without the key an open surface from both, and a closed one from where bodies start.
void choose_sides(const KeyedMap& map, bool closed, MeshSurface& surface) {
  const Value* key = map.find("sides");
  const std::string sides = map.key("sides").names[map.choice("sides")];
  if (sides == "front" || sides == "back") {
    if (surface.two_sided) key->fail(sides + " of a surface whose triangles do not agree which side is out", "auto or both");
    if (sides == "back") turn_over(surface);
  } else if (sides == "both") {
    touch_from_both(surface);
  } else if (!surface.two_sided) {
    if (closed)
      surface.sides_by_bodies = true;
    else
      touch_from_both(surface);
  }
}

Shape read_soup(const KeyedMap& map, const Scene& scene) {
  std::string path;
  TriangleMesh mesh = read_mesh(map, "file", scene, path, true);
  const SoupFaults faults = mend_soup(mesh, path, read_weld(map, "file"));
  MeshSurface surface = make_mesh_shape(mesh.nodes, mesh.triangles, 0, faults.both_ways);
  const std::string what = describe(faults, surface.two_sided, holes_of(mesh));
  if (!what.empty()) surface.note = path + ": " + what;
  surface.name = path;
  choose_sides(map, surface.is_solid, surface);
  return shape_library().add(std::move(surface));
}

Key surface_file(const char* name, const char* without, const char* about) {
  return keys::text(name, "an OBJ, STL, PLY, glTF or DAE file", without, about);
}

}  // namespace

const Keys& hull_keys() {
  static const Keys table{
      "hull",
      "The convex hull of points, in axes and from an origin of their own; its centre of mass comes to the entry's position.",
      {keys::list("points", "m", "a list of points", "a mesh", "points that span the hull",
                  [] { return keys::list_of(keys::of_type("number"), 3); }),
       surface_file("mesh", "points",
                    "OBJ, STL, PLY, glTF or DAE file, its path from the scene's folder, whose nodes span the hull"),
       keys::scale(), keys::up()}};
  return table;
}

const Keys& compound_keys() {
  static const Keys table{
      "compound",
      "Convex shapes that move as one; its centre of mass comes to the entry's position.",
      {keys::list_of_maps("parts", compound_part_keys, "a list of shapes with positions", "a mesh", "convex shapes"),
       keys::choice("overlap", {"twice", "once"}, "twice",
                    "how mass counts where parts overlap: that of each, or that of the first of them"),
       surface_file("mesh", "parts", "OBJ, STL, PLY, glTF or DAE file of a closed surface, its path from the scene's folder"),
       keys::scale(), keys::up(), keys::weld(),
       keys::integer("pieces", 1, 32, 6,
                     "cells along the mesh's longest side, by which it is cut into convex pieces for contact"),
       surface_file(
           "pieces_file", "pieces",
           "OBJ, STL, PLY, glTF or DAE file of the convex pieces instead, each a surface of its own, in the mesh's axes and "
           "lengths")}};
  return table;
}

const Keys& mesh_shape_keys() {
  static const Keys table{
      "mesh",
      "A surface of triangles, which is fixed or kinematic.",
      {surface_file("file", "another", "OBJ, STL, PLY, glTF or DAE file, its path from the scene's folder"), keys::scale(),
       keys::up(), keys::weld(),
       keys::choice("sides", {"auto", "front", "back", "both"}, "auto",
                    "from where a surface of a file, or a revolved one, is touched: front is where its triangles turn "
                    "counterclockwise; auto: an open one from both sides, a closed one from where bodies start"),
       keys::map("height_field", height_field_keys, "a map", "another", "terrain"),
       keys::map("tube", tube_keys, "a map", "another", "the inside of a drum"),
       keys::map("revolve", revolved_keys, "a map", "another", "what a line covers that turns about z")}};
  return table;
}

std::string surface_path(const Value& file, const Scene& scene) {
  const auto path = std::filesystem::path(scene.path).parent_path() / file.string("an OBJ, STL, PLY, glTF or DAE file");
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error))
    file.fail(path.string() + (std::filesystem::exists(path, error) ? ", which isn't a file" : ", which isn't there"),
              "an OBJ, STL, PLY, glTF or DAE file, its path from the scene's folder");
  return path.string();
}

Shape read_hull(const Value& value, const Scene& scene) {
  const KeyedMap map(value, hull_keys());
  const Value *list = map.find("points"), *mesh = map.find("mesh");
  if ((list != nullptr) == (mesh != nullptr)) value.fail("both or none of points and mesh", "one of the two");
  if (mesh) {
    std::string path;
    return add_hull(value, read_mesh(map, "mesh", scene, path).nodes);
  }
  map.none_of({"scale", "up"}, "beside points");
  std::vector<Vec3> points;
  for (const Value& point : list->list("points")) points.push_back(point.vector(any_number, "m"));
  return add_hull(*list, points);
}

namespace {

struct Extent {
  Vec3 low, high;
};

Extent extent_of_nodes(const std::vector<Vec3>& nodes) {
  Extent extent{nodes[0], nodes[0]};
  for (const Vec3& x : nodes) extent.low = extent.low.cwiseMin(x), extent.high = extent.high.cwiseMax(x);
  return extent;
}

std::string place_text(const Vec3& x) {
  std::array<char, 96> text{};
  std::snprintf(text.data(), text.size(), "[%.4g, %.4g, %.4g]", x.x(), x.y(), x.z());
  return text.data();
}

// Pieces of another length or in other axes than the mesh would be wrong without a word: they must reach as far.
std::vector<Hull> pieces_from_file(const KeyedMap& map, const Scene& scene, const TriangleMesh& mesh) {
  std::string path;
  const Value& file = map.need("pieces_file");
  const TriangleMesh surfaces = read_mesh(map, "pieces_file", scene, path);
  const Extent of_mesh = extent_of_nodes(mesh.nodes), of_pieces = extent_of_nodes(surfaces.nodes);
  const double allowed = 0.05 * (of_mesh.high - of_mesh.low).maxCoeff();
  for (const auto end : {&Extent::low, &Extent::high}) {
    const Vec3 &expected = of_mesh.*end, &found = of_pieces.*end;
    if ((expected - found).cwiseAbs().maxCoeff() <= allowed) continue;
    file.fail(path + ", whose pieces reach to " + place_text(found) + " m, by scale and up",
              "pieces that reach as far as the mesh, to " + place_text(expected) + " m, within 5 % of its longest side");
  }
  try {
    return convex_parts(surfaces);
  } catch (const std::invalid_argument& fault) {
    file.fail(path + ", of which " + fault.what(), "convex pieces, each a closed surface of its own");
  }
}

}  // namespace

Shape read_compound(const Value& value, const Scene& scene) {
  const KeyedMap map(value, compound_keys());
  const Value *list = map.find("parts"), *file = map.find("mesh");
  if ((list != nullptr) == (file != nullptr)) value.fail("both or none of parts and mesh", "one of the two");
  std::vector<Compound::Part> parts;
  if (list) {
    map.none_of({"scale", "up", "weld", "pieces", "pieces_file"}, "beside parts");
    for (const Value& part : list->list("shapes with positions")) parts.push_back(read_compound_part(part, scene));
    const std::vector<double> densities = read_densities(*list);
    const auto overlap = static_cast<Overlap>(map.choice("overlap"));
    if (densities.empty() && overlap == Overlap::twice) return shape_library().add(make_compound(parts));
    const CompoundMass mass = compound_mass(parts, densities.empty() ? std::vector<double>(parts.size(), 1) : densities, overlap);
    Compound compound = make_compound(parts, moments_of(mass.volume, mass.centre, mass.second));
    compound.mass = densities.empty() ? 0 : mass.mass;
    return shape_library().add(std::move(compound));
  }
  map.none_of({"overlap"}, "beside a mesh");
  std::string path;
  TriangleMesh mesh = read_mesh(map, "mesh", scene, path);
  const double share = read_weld(map, "mesh");
  if (!mesh_topology(mesh, path).boundary.empty()) {  // a closed surface may have parts that touch, and keeps them
    const std::size_t before = mesh.nodes.size();
    const auto number = weld(mesh.nodes, share * extent_of(mesh.nodes));
    if (mesh.nodes.size() < before) renumber(mesh.triangles, number);
  }
  const SolidMoments moments = check_closed(mesh, *file, path);
  if (map.has("pieces_file")) map.none_of({"pieces"}, "beside pieces_file");
  std::vector<Hull> pieces =
      map.has("pieces_file") ? pieces_from_file(map, scene, mesh) : convex_pieces(mesh, static_cast<int>(map.integer("pieces")));
  for (Hull& piece : pieces) {
    const Vec3 centre = piece.centre;
    parts.push_back({shape_library().add(std::move(piece)), centre, Quat::Identity()});
  }
  return shape_library().add(make_compound(parts, moments));
}

Shape read_mesh_shape(const Value& value, const Scene& scene) {
  const KeyedMap map(value, mesh_shape_keys());
  const Value *file = map.find("file"), *made = nullptr;
  int count = file ? 1 : 0;
  for (const char* key : {"height_field", "tube", "revolve"})
    if (const Value* found = map.find(key)) made = found, ++count;
  if (count != 1) value.fail("not one of file, height_field, tube and revolve", "one of the four");
  const bool revolves = made != nullptr && made == map.find("revolve");
  if (file) return read_soup(map, scene);
  map.none_of({"scale", "up", "weld"}, "without a file");
  if (!revolves) map.none_of({"sides"}, "without a file or a revolved surface");
  double below = 0;
  const TriangleMesh mesh = revolves                           ? read_revolved(*made)
                            : made == map.find("height_field") ? read_height_field(*made, below)
                                                               : read_tube(*made);
  check_mesh(mesh, place_of(*made));
  MeshSurface surface = make_mesh_shape(mesh.nodes, mesh.triangles, below);
  if (revolves) choose_sides(map, surface.is_solid, surface);
  return shape_library().add(std::move(surface));
}

std::string note_of(const Shape& shape) { return shape.kind == ShapeKind::mesh ? shape_library().meshes[shape.data].note : ""; }

}  // namespace unibody
