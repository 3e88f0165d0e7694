#include "scene/joint_keys.hpp"

#include <algorithm>
#include <utility>

#include "scene/in_time.hpp"
#include "scene/joints.hpp"
#include "scene/strength.hpp"

namespace unibody {

namespace {

constexpr std::size_t kinds = joint_names.size();
const std::vector<std::string> joint_kind_names{joint_names.begin(), joint_names.end()};

bool takes_axis(JointKind kind) {
  return kind == JointKind::hinge || kind == JointKind::slider || kind == JointKind::universal || kind == JointKind::ball;
}

const Keys& turning_motor_keys() {
  static const Keys table{"turning_motor",
                          "The motor of a hinge.",
                          {keys::number_in_time("speed", "rad/s", any_number, "an angle", "angle by which it turns in a second"),
                           keys::number_in_time("angle", "degrees", {-180, 180}, "a speed",
                                                "angle that it seeks, no faster than half of its strength can brake"),
                           keys::number_in_time("max_torque", "N m", not_negative, needed, "the most that the motor gives")}};
  return table;
}

const Keys& sliding_motor_keys() {
  static const Keys table{"sliding_motor",
                          "The motor of a slider.",
                          {keys::number_in_time("speed", "m/s", any_number, "an offset", "how far it moves in a second"),
                           keys::number_in_time("offset", "m", any_number, "a speed",
                                                "offset that it seeks, no faster than half of its strength can brake"),
                           keys::number_in_time("max_force", "N", not_negative, "max_pressure", "the most that the motor gives"),
                           keys::number_in_time("max_pressure", "Pa", not_negative, "max_force",
                                                "the most that the motor gives, as a pressure on the area"),
                           keys::number("area", "m^2", positive, "no pressure", "on which the pressure acts")}};
  return table;
}

const Keys& turning_spring_keys() {
  static const Keys table{
      "turning_spring",
      "A spring and a damper that turn a hinge.",
      {keys::number("stiffness", "N m/rad", not_negative, "none", "torque of the spring for each radian away from its rest"),
       keys::number("damping", "N m s/rad", not_negative, 0, "torque against the motion, for each rad/s"),
       keys::number("rest", "degrees", {-180, 180}, 0, "angle at which the spring is at rest")}};
  return table;
}

const Keys& sliding_spring_keys() {
  static const Keys table{
      "sliding_spring",
      "A spring and a damper along a slider.",
      {keys::number("stiffness", "N/m", not_negative, "none", "force of the spring for each metre away from its rest"),
       keys::number("damping", "N s/m", not_negative, 0, "force against the motion, for each m/s"),
       keys::number("rest", "m", any_number, 0, "offset at which the spring is at rest")}};
  return table;
}

// How a joint behaves, beside where it is.
std::vector<Key> behaviour_keys(JointKind kind) {
  const bool turns = turns_about_axis(kind);
  std::vector<Key> keys{
      keys::flag("collide", false, "its bodies may touch each other; of several joints between them each must say so"),
      keys::number("compliance", "m/N", not_negative, 0, "of rows that measure a length: 1 / stiffness"),
      keys::number("damping", "s", not_negative, 0, "rho: its rows see c + rho dc/dt; a rope never pushes")};
  if (!ties_points(kind) && kind != JointKind::ball)
    keys.push_back(
        keys::number("turning_compliance", "rad/(N m)", not_negative, 0, "of rows that measure an angle: 1 / stiffness"));
  keys.push_back(strength_key(ties_points(kind) || kind == JointKind::ball ? pull_strength_keys : joint_strength_keys));
  if (kind == JointKind::hinge || kind == JointKind::slider) {
    keys.push_back(keys::numbers("limits", 2, turns ? "degrees" : "m", turns ? Range{-180, 180} : any_number, "none",
                                 "lower and upper limit of a hinge's angle or a slider's offset"));
    keys.push_back(keys::map("motor", turns ? turning_motor_keys : sliding_motor_keys, "a map", "none", "its motor"));
    keys.push_back(
        keys::number("friction", turns ? "N m" : "N", not_negative, 0, "the most that dry friction gives against its motion"));
    keys.push_back(keys::map("spring", turns ? turning_spring_keys : sliding_spring_keys, "a map", "none",
                             "a spring and a damper about a hinge's angle or along a slider's offset"));
  }
  if (kind == JointKind::ball) {
    keys.push_back(keys::number("swing_limit", "degrees", {0, 180, true}, "none",
                                "of a ball: the most that the axes of the two bodies part"));
    keys.push_back(keys::numbers("twist_limits", 2, "degrees", {-180, 180}, "none",
                                 "of a ball: lower and upper limit of what the first body is turned about its axis"));
  }
  return keys;
}

Key pair_of(const char* name, const char* unit, const char* words, const char* without, const char* about) {
  return keys::other(name, unit, words, without, about,
                     [] { return keys::list_of(keys::list_of(keys::of_type("number"), 3), 2); });
}

Key type_key(std::vector<std::string> types) {
  return keys::choice("type", std::move(types), needed, "what the joint leaves free");
}

Keys entry_keys(JointKind kind) {
  const bool span = ties_points(kind);
  Keys table{"joint_" + joint_kind_names[static_cast<std::size_t>(kind)], "", behaviour_keys(kind)};
  table.in_reference = false;
  const auto add = [&](const Key& key) { table.keys.push_back(key); };
  add(keys::text("name", "a name", "none", "by which events call it; several joints may have one name"));
  add(type_key(joint_kind_names));
  add(keys::other("bodies", "", "a list of 2 bodies, the second of which may be world", needed,
                  "its bodies: names, as door or pile[3], or places of entries in the list of bodies; one must be dynamic", [] {
                    return keys::list_of(Json::object().set("type", keys::texts({"string", "integer"})), 2);
                  }));
  add(pair_of("anchors", "m", "a list of 2 points in the bodies' axes", span ? "points" : "an anchor",
              "its anchor in each body, in the axes in which the scene or the file gives its shape"));
  if (span)
    add(pair_of("points", "m", "a list of 2 points", "anchors",
                "of a rope or spring: where its anchors are at the start, world axes"));
  else
    add(keys::vector("anchor", "m", "anchors", "where both anchors are at the start, world axes"));
  if (span)
    add(keys::number("length", "m", positive, "as at the start",
                     "the most that a rope's anchors are apart; how far a spring's are at rest"));
  if (takes_axis(kind)) {
    add(keys::direction("axis", "axes, or none of a ball without limits", "its axis at the start, world axes"));
    add(pair_of("axes", "", "a list of 2 vectors of length 1", "an axis", "its axis in each body, in the same axes as anchors"));
  }
  if (kind == JointKind::universal)
    add(keys::direction("second_axis", "any", "of a universal joint: the axis of the second body, square to the first"));
  return table;
}

Keys template_keys(JointKind kind) {
  Keys table{"joints_" + joint_kind_names[static_cast<std::size_t>(kind)], "", behaviour_keys(kind)};
  table.in_reference = false;
  table.keys.push_back(type_key({"ball", "hinge", "universal", "fixed"}));
  if (takes_axis(kind)) table.keys.push_back(keys::direction("axis", "[0, 1, 0]", "axis of each joint, in the entry's axes"));
  if (kind == JointKind::universal)
    table.keys.push_back(
        keys::direction("second_axis", "[0, 0, 1]", "of universal joints: the second axis, square to the first"));
  return table;
}

template <Keys (*make)(JointKind), std::size_t kind>
const Keys& made() {
  static const Keys table = make(static_cast<JointKind>(kind));
  return table;
}

template <Keys (*make)(JointKind)>
std::array<KeysOf, kinds> tables_of() {
  return []<std::size_t... kind>(std::index_sequence<kind...>) { return std::array<KeysOf, kinds>{made<make, kind>...}; }
  (std::make_index_sequence<kinds>{});
}

// A key that differs by type: of either unit and form.
void merge(Key& key, const Key& other) {
  if (key.unit != other.unit) key.unit += " or " + other.unit;
  for (const KeysOf table : other.maps)
    if (std::ranges::find(key.maps, table) == key.maps.end()) key.maps.push_back(table);
}

// The keys of joints of all these types; the schema says which a type has.
Keys all_of(const char* name, const char* about, const std::vector<KeysOf>& tables, const std::vector<std::string>& types) {
  Keys all{name, about, {}};
  for (const KeysOf table : tables)
    for (const Key& key : table().keys) {
      const auto known = std::ranges::find(all.keys, key.name, &Key::name);
      if (known == all.keys.end())
        all.keys.push_back(key);
      else if (known->unit != key.unit || known->maps != key.maps)
        merge(*known, key);
    }
  all.types = tables;
  all.restrict_schema = [tables, types](Json& schema) {
    Json rules = Json::array();
    for (std::size_t k = 0; k < tables.size(); ++k) {
      const Json is = Json::object().set("properties", Json::object().set("type", Json::object().set("const", types[k])));
      rules.push(Json::object().set("if", is).set("then", keys::reference_to(tables[k])));
    }
    schema = Json::object()
                 .set("type", "object")
                 .set("required", keys::texts({"type"}))
                 .set("properties", Json::object().set("type", Json::object().set("enum", keys::texts(types))))
                 .set("allOf", rules);
  };
  return all;
}

}  // namespace

const Keys& joint_spring_keys(bool turns) { return turns ? turning_spring_keys() : sliding_spring_keys(); }
const Keys& motor_keys(bool turns) { return turns ? turning_motor_keys() : sliding_motor_keys(); }
const Keys& joint_keys_of(JointKind kind) { return tables_of<entry_keys>()[static_cast<std::size_t>(kind)](); }
const Keys& joint_template_keys_of(JointKind kind) { return tables_of<template_keys>()[static_cast<std::size_t>(kind)](); }

const Keys& joint_keys() {
  static const Keys table = [] {
    const auto tables = tables_of<entry_keys>();
    return all_of("joint", "A joint between two bodies, or between a body and the world.", {tables.begin(), tables.end()},
                  joint_kind_names);
  }();
  return table;
}

const Keys& joint_template_keys() {
  static const Keys table = [] {
    const std::vector<std::string> types{"ball", "hinge", "universal", "fixed"};
    std::vector<KeysOf> tables;
    for (const std::string& type : types)
      tables.push_back(tables_of<template_keys>()[static_cast<std::size_t>(std::ranges::find(joint_kind_names, type) -
                                                                           joint_kind_names.begin())]);
    return all_of("joints_of_a_generator", "The joints of a generator, all alike.", tables, types);
  }();
  return table;
}

}  // namespace unibody
