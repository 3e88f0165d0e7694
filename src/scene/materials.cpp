#include "scene/materials.hpp"

#include <array>
#include <cmath>
#include <set>
#include <type_traits>

#include "scene/in_time.hpp"

namespace unibody {

namespace {

// What a pair of materials may say beside its friction, and of a pair that isn't listed, what it has from its two materials.
struct PairKey {
  Key key;
  std::vector<double> Scene::*values;
  double (*mix)(double, double);
};
double smaller(double a, double b) { return std::min(a, b); }
double geometric_mean(double a, double b) { return std::sqrt(a * b); }
const std::array<PairKey, 3>& pair_keys() {
  static const std::array<PairKey, 3> list{
      {{keys::number("restitution", "", {0, 1}, 0, "speed after an impact over that before it"), &Scene::restitution, smaller},
       {keys::number("rolling_friction", "m", not_negative, 0, "torque that resists rolling, over the normal force"),
        &Scene::rolling, geometric_mean},
       {keys::number("spinning_friction", "m", not_negative, 0, "torque that resists spinning, over the normal force"),
        &Scene::spinning, geometric_mean}}};
  return list;
}

Keys keys_of(const char* name, const char* about, const Without& friction, const std::vector<Key>& first) {
  Keys table{name, about, first};
  table.keys.push_back(keys::number_in_time("friction", "", not_negative, friction, "Coulomb's coefficient of friction"));
  for (const PairKey& pair : pair_keys()) table.keys.push_back(pair.key);
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
  for (const PairKey& k : pair_keys()) {
    std::vector<double>& values = scene.*k.values;
    values[a * n + b] = values[b * n + a] = pair.number_if(k.key.name).value_or(values[a * n + b]);
    other |= pair.has(k.key.name);
  }
  if (pair.has("friction") || !other) friction.pairs[a * n + b] = friction.pairs[b * n + a] = read_in_time(pair, "friction");
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

// Names with what they are, and the key `pairs`. A pair that isn't listed has the geometric mean of its two materials; its
// restitution is the smaller of the two.
void read_materials(const Value& value, Scene& scene) {
  if (value.kind != Value::Kind::map) value.fail_expected("a map of materials");
  scene.materials.clear();
  FrictionInTime friction;
  std::array<std::vector<double>, std::tuple_size_v<std::remove_cvref_t<decltype(pair_keys())>>> others;
  for (const auto& [name, material] : value.children) {
    if (name == "pairs") continue;
    scene.materials.push_back(name);
    const KeyedMap map(material, material_keys());
    friction.materials.push_back(read_in_time(map, "friction"));
    for (std::size_t k = 0; k < others.size(); ++k) others[k].push_back(map.number(pair_keys()[k].key.name));
  }
  if (friction.materials.empty()) value.fail("no material", "at least one, as wood: {friction: 0.5}");
  const std::size_t n = friction.materials.size();
  friction.pairs.resize(n * n);
  const auto mix = [n](const std::vector<double>& own, double (*rule)(double, double)) {
    std::vector<double> all;
    for (std::size_t i = 0; i < n * n; ++i) all.push_back(i / n == i % n ? own[i / n] : rule(own[i / n], own[i % n]));
    return all;
  };
  for (std::size_t k = 0; k < others.size(); ++k) scene.*pair_keys()[k].values = mix(others[k], pair_keys()[k].mix);
  Pairs listed;
  if (const Value* pairs = value.find("pairs"))
    for (const Value& pair : pairs->list("pairs of materials")) read_pair(pair, scene, listed, friction);
  scene.friction = friction.at(0);
  if (friction.changes()) scene.friction_in_time = std::move(friction);
}

}  // namespace unibody
