#include "scene/shape_entry.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "core/text.hpp"
#include "scene/shape_files.hpp"
#include "world/shape_type.hpp"

namespace unibody {

namespace {

const std::vector<std::string> names{shape_names.begin(), shape_names.end()};

// The table of a shape that is given by lengths alone, as its type says (world/shape_type.hpp).
template <std::size_t kind>
const Keys& lengths_keys() {
  static const Keys table = [] {
    Keys keys{names[kind], "A " + names[kind] + ".", {}};
    for (const ShapeLength& length : type_of(static_cast<ShapeKind>(kind)).lengths)
      keys.keys.push_back(keys::number(length.key, "m", positive, needed, length.about));
    return keys;
  }();
  return table;
}

const Keys& box_keys() {
  static const Keys table{"box_shape",
                          "A box about the origin.",
                          {keys::numbers("size", 3, "m", positive, needed, "lengths of the edges along x, y and z")}};
  return table;
}

const Keys& plane_keys() {
  static const Keys table{
      "plane",
      "A half space.",
      {keys::direction("normal", needed, "normal of the plane through the entry's position, out of what is solid")}};
  return table;
}

KeysOf table_of(ShapeKind kind) {
  switch (kind) {
    case ShapeKind::box:
      return box_keys;
    case ShapeKind::plane:
      return plane_keys;
    case ShapeKind::hull:
      return hull_keys;
    case ShapeKind::compound:
      return compound_keys;
    case ShapeKind::mesh:
      return mesh_shape_keys;
    default:
      break;
  }
  static constexpr auto tables = []<std::size_t... kinds>(std::index_sequence<kinds...>) {
    return std::array<KeysOf, sizeof...(kinds)>{lengths_keys<kinds>...};
  }
  (std::make_index_sequence<shape_names.size()>{});
  return tables[static_cast<std::size_t>(kind)];
}

Shape read_lengths(const Value& solid, ShapeKind kind) {
  const KeyedMap map(solid, table_of(kind)());
  std::vector<double> lengths;
  for (const ShapeLength& length : type_of(kind).lengths) lengths.push_back(map.number(length.key));
  return type_of(kind).make(lengths);
}

}  // namespace

const Keys& shape_keys() {
  static const Keys table = [] {
    Keys keys{"shape", "A shape: one key, with the map that says its size.", {}};
    for (std::size_t kind = 0; kind < names.size(); ++kind)
      keys.keys.push_back(keys::map(names[kind].c_str(), table_of(static_cast<ShapeKind>(kind)), "a map", "another shape",
                                    ("the shape is a " + names[kind]).c_str()));
    keys.restrict_schema = [](Json& schema) { schema.set("minProperties", 1).set("maxProperties", 1); };
    return keys;
  }();
  return table;
}

Key shape_key(const Without& without) {
  static const std::string words = "a map with the key " + one_of(names);
  return keys::map("shape", shape_keys, words.c_str(), without, "the shape of each body");
}

Vec3 read_plane_normal(const Value& plane, const Scene& scene) {
  const KeyedMap map(plane, plane_keys());
  const Vec3 n = map.direction("normal");
  if (scene.planar && n.y() != 0) map.need("normal").fail_expected("a vector without y component (planar scene)");
  return n;
}

Shape read_shape(const Value& value, const Scene& scene) {
  const KeyedMap shape(value, shape_keys());
  if (value.children.size() != 1)
    value.fail("a map of " + std::to_string(value.children.size()) + " shapes", "one of " + one_of(names));
  const auto& [name, solid] = value.children[0];
  const auto kind = static_cast<ShapeKind>(std::ranges::find(names, name) - names.begin());
  if (kind == ShapeKind::disc && !scene.planar) solid.fail("a disc", "sphere, box or plane in a scene that is not planar");
  if (kind > ShapeKind::particle && scene.planar) solid.fail("a " + name, "sphere, box, plane or disc in a planar scene");
  if (kind == ShapeKind::plane) {
    read_plane_normal(solid, scene);
    return {ShapeKind::plane, Vec3::Zero()};
  }
  if (kind == ShapeKind::box) return {ShapeKind::box, 0.5 * KeyedMap(solid, box_keys()).vector("size")};
  if (kind == ShapeKind::hull) return read_hull(solid, scene);
  if (kind == ShapeKind::compound) return read_compound(solid, scene);
  if (kind == ShapeKind::mesh) return read_mesh_shape(solid, scene);
  return read_lengths(solid, kind);
}

}  // namespace unibody
