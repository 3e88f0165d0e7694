#include "scene/materials.hpp"

#include <array>
#include <set>

#include "scene/in_time.hpp"

namespace unibody {

namespace {

Keys keys_of(const char* name, const char* about, const Without& friction, const std::vector<Key>& first) {
  Keys table{name, about, first};
  table.keys.push_back(keys::number_in_time("friction", "", not_negative, friction, "Coulomb's coefficient of friction"));
  for (const PairValueType& type : pair_value_types)
    table.keys.push_back(keys::number(type.key, type.unit, {0, type.most, type.usual > 0}, type.usual, type.about));
  return table;
}

const Keys& material_keys() {
  static const Keys table = keys_of("material", "A material; `friction` is between two bodies of it.", needed, {});
  return table;
}

// What a pair does not say follows from its two materials.
const Keys& material_pair_keys() {
  static const Keys table = [] {
    const Key between = keys::other("between", "", "a list of 2 materials", needed, "two different materials",
                                    [] { return keys::list_of(keys::of_type("string"), 2); });
    Keys of_pair = keys_of("pair", "Two materials that touch each other.", "by its materials", {between});
    for (std::size_t k = 2; k < of_pair.keys.size(); ++k) of_pair.keys[k].without = "by its materials";
    return of_pair;
  }();
  return table;
}

using Pairs = std::set<std::pair<std::size_t, std::size_t>>;

void read_pair(const Value& value, Scene& scene, Pairs& listed, FrictionInTime& friction) {
  const KeyedMap pair(value, material_pair_keys());
  const Value* between = &pair.need("between");
  if (between->kind != Value::Kind::list || between->entries.size() != 2) between->fail_expected(pair.key("between").words);
  const std::size_t a = between->entries[0].choice(scene.materials), b = between->entries[1].choice(scene.materials);
  if (a == b) between->fail_expected("two different materials");
  if (!listed.emplace(std::min(a, b), std::max(a, b)).second)
    between->fail(between->found() + " a second time", "each pair once");
  const std::size_t n = scene.materials.size();
  bool other = false;
  for (std::size_t k = 0; k < pair_value_types.size(); ++k) {
    std::vector<double>& values = scene.pairs.values[k];
    values[a * n + b] = values[b * n + a] = pair.number_if(pair_value_types[k].key).value_or(values[a * n + b]);
    other |= pair.has(pair_value_types[k].key);
  }
  if (pair.has("friction") || !other)
    friction.pairs[a * n + b] = friction.pairs[b * n + a] = read_in_time(pair, "friction", scene);
}

}  // namespace

Key materials_key() {
  const auto schema = [] {
    return Json::object()
        .set("type", "object")
        .set("properties", Json::object().set("pairs", keys::list_of(keys::reference_to(material_pair_keys))))
        .set("additionalProperties", keys::reference_to(material_keys));
  };
  return keys::other("materials", "", "a map of materials", "{default: {friction: 0.5}}",
                     "materials by their names, and `pairs` of them that differ from what their materials say", schema,
                     {material_keys, material_pair_keys});
}

// Names with what they are, and the key `pairs`. A pair that isn't listed has the geometric mean of its two materials' friction.
void read_materials(const Value& value, Scene& scene) {
  if (value.kind != Value::Kind::map) value.fail_expected("a map of materials");
  scene.materials.clear();
  FrictionInTime friction;
  std::array<std::vector<double>, pair_value_types.size()> own;  // of each material
  for (const auto& [name, material] : value.children) {
    if (name == "pairs") continue;
    scene.materials.push_back(name);
    const KeyedMap map(material, material_keys());
    friction.materials.push_back(read_in_time(map, "friction", scene));
    for (std::size_t k = 0; k < own.size(); ++k) own[k].push_back(map.number(pair_value_types[k].key));
  }
  if (friction.materials.empty()) value.fail("no material", "at least one, as wood: {friction: 0.5}");
  const std::size_t n = friction.materials.size();
  friction.pairs.resize(n * n);
  scene.pairs.materials = n;
  for (std::size_t k = 0; k < own.size(); ++k) {
    scene.pairs.values[k].clear();
    for (std::size_t i = 0; i < n * n; ++i)
      scene.pairs.values[k].push_back(i / n == i % n ? own[k][i / n]
                                                     : MaterialPairs::mixed(pair_value_types[k], own[k][i / n], own[k][i % n]));
  }
  Pairs listed;
  if (const Value* pairs = value.find("pairs"))
    for (const Value& pair : pairs->list("pairs of materials")) read_pair(pair, scene, listed, friction);
  scene.friction = friction.at(0);
  if (friction.changes()) scene.friction_in_time = std::move(friction);
}

}  // namespace unibody
