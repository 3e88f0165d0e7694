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

// Two laws at once would be neither; and how a contact that gives way rebounds follows from its damping.
void check_law(const Value& value, const Scene& scene, std::size_t a, std::size_t b) {
  const std::string between = a == b ? "" : " between " + scene.materials[a] + " and " + scene.materials[b];
  const auto of = [&](PairValue which) { return scene.pairs.of(which, static_cast<int>(a), static_cast<int>(b)); };
  const bool linear = of(PairValue::stiffness) > 0, hertz = of(PairValue::elastic_modulus) > 0;
  if (linear && hertz) value.fail("stiffness and elastic_modulus" + between, "one of the two");
  if ((linear || hertz) && of(PairValue::restitution) > 0)
    value.fail(std::string("restitution beside ") + (linear ? "stiffness" : "elastic_modulus") + between,
               "damping or damping_ratio, from which the rebound of such a contact follows");
  if (!linear && !hertz && (of(PairValue::damping) > 0 || of(PairValue::damping_ratio) > 0))
    value.fail("a damping of rigid contacts" + between, "stiffness or elastic_modulus beside it");
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

// Of each material with itself, and of each pair, which may have them from its materials.
void check_all_laws(const Value& value, const Scene& scene) {
  std::size_t a = 0;
  for (const auto& [name, material] : value.children)
    if (name != "pairs") check_law(material, scene, a, a), ++a;
  for (a = 0; a < scene.materials.size(); ++a)
    for (std::size_t b = 0; b < a; ++b) check_law(value, scene, a, b);
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
  check_all_laws(value, scene);
  scene.friction = friction.at(0);
  if (friction.changes()) scene.friction_in_time = std::move(friction);
}

}  // namespace unibody
