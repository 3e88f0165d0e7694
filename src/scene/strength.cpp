#include "scene/strength.hpp"

#include <algorithm>

#include "core/text.hpp"

namespace unibody {

namespace {

struct StrengthKey {
  const char *name, *unit, *about;
  double Strength::*value;
};
const std::array<StrengthKey, 6> strength_types{
    {{"force", "N", "force of any direction", &Strength::force},
     {"torque", "N m", "torque about any axis", &Strength::torque},
     {"tension", "N", "pull along the line between the bodies, less what bending takes of it", &Strength::tension},
     {"shear", "N", "force across that line, less what twisting takes of it", &Strength::shear},
     {"bending", "N m", "torque across that line, less what tension takes of it", &Strength::bending},
     {"twisting", "N m", "torque about that line, less what shear takes of it", &Strength::twisting}}};

Keys keys_of_first(std::size_t count, const char* name, const char* about) {
  Keys table{name, about, {}};
  for (std::size_t k = 0; k < count; ++k)
    table.keys.push_back(
        keys::number(strength_types[k].name, strength_types[k].unit, positive, "infinite", strength_types[k].about));
  table.keys.push_back(duration_key());
  return table;
}

}  // namespace

const Keys& pull_strength_keys() {
  static const Keys table = keys_of_first(1, "pull_strength", "What a joint bears that does not hold its bodies' turns.");
  return table;
}

const Keys& joint_strength_keys() {
  static const Keys table = keys_of_first(2, "joint_strength", "What a joint bears, by itself each.");
  return table;
}

const Keys& bond_strength_keys() {
  static const Keys table = keys_of_first(6, "bond_strength", "What a bond bears.");
  return table;
}

Key duration_key() {
  return keys::number("duration", "s", not_negative, Strength::usual_duration,
                      "loads are means over such a time, of five steps at least, in which the past fades; 0: those of a step");
}

Key strength_key(KeysOf table) {
  return keys::map("strength", table, "a map", "infinite", "the most that it bears: it breaks in a step in which it bears more");
}

Strength read_strength(const Value& value, const Keys& table) {
  const KeyedMap map(value, table);
  Strength strength;
  std::vector<std::string> names;
  for (const StrengthKey& type : strength_types)
    if (std::ranges::find(table.keys, type.name, &Key::name) != table.keys.end())
      names.emplace_back(type.name), strength.*type.value = map.number_if(type.name).value_or(Strength::infinity);
  strength.duration = map.number("duration");
  if (!strength.any()) value.fail("no force or torque that breaks it", "one of the keys " + one_of(names));
  return strength;
}

}  // namespace unibody
