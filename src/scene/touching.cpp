#include "scene/touching.hpp"

#include <algorithm>
#include <map>
#include <string>

#include "scene/entry_name.hpp"

namespace unibody {

namespace {

constexpr const char* entry_words = "the name of an entry of bodies, cloths, threads or solids";

Json names_schema() { return keys::of_type("array").set("items", keys::of_type("string")); }

const Keys& collide_keys() {
  static const Keys table{
      "collide",
      "Which entries the bodies may touch: those of some names, or all but those. Two bodies touch where neither's entry "
      "excludes "
      "the other's.",
      {keys::other("with", "", "a list of names of entries, which may be empty", "without, or all",
                   "the entries whose bodies they touch; their own entry as well has to be named", names_schema),
       keys::other("without", "", "a list of names of entries", "with, or none", "the entries whose bodies they do not touch",
                   names_schema)}};
  return table;
}

// Each name that some entry's `collide` mentions has a bit; entries that none mentions share the lowest.
class Names {
 public:
  explicit Names(const Scene& scene) : scene_(scene) {}

  std::uint64_t bit(const Value& value) {
    constexpr std::size_t most = 63;
    const std::string name = value.string(entry_words);
    if (const auto known = bits_.find(name); known != bits_.end()) return known->second;
    const auto has_name = [&](const BodyGroup& group) { return !name.empty() && group.name == name; };
    if (std::ranges::none_of(scene_.groups, has_name)) fail_without_entry(value, name, scene_, Entries::all, entry_words);
    if (bits_.size() == most)
      value.fail(value.found() + ", the name of one entry more", "at most " + std::to_string(most) + " names in all of collide");
    return bits_.emplace(name, std::uint64_t{2} << bits_.size()).first->second;
  }
  std::uint64_t bit_of(const std::string& name) const {
    const auto known = bits_.find(name);
    return known == bits_.end() ? 1 : known->second;
  }

 private:
  const Scene& scene_;
  std::map<std::string, std::uint64_t> bits_;
};

std::uint64_t read_touched(const Value& value, Names& names) {
  const KeyedMap map(value, collide_keys());
  map.only_one_of({"with", "without"});
  const Value *with = map.find("with"), *without = map.find("without");
  if (!with && !without) value.fail_missing("with", "a list of names of entries, or without: one");
  std::uint64_t bits = 0;
  const Value& list = with ? *with : *without;
  if (list.kind != Value::Kind::list) list.fail_expected(with ? map.key("with").words : map.key("without").words);
  for (const Value& name : list.entries) bits |= names.bit(name);
  return with ? bits : ~bits;
}

}  // namespace

Key collide_key() {
  return keys::map("collide", collide_keys, "a map with a list of names, with or without", "with all",
                   "which entries the bodies may touch");
}

void read_touching(const Value& root, Scene& scene) {
  const std::vector<Value>& entries = root.find("bodies") ? root.find("bodies")->entries : root.entries;
  Names names(scene);
  std::vector<std::uint64_t> touches(scene.groups.size(), ~std::uint64_t{0});
  for (std::size_t g = 0; g < entries.size(); ++g)  // each is a group of the scene, in this order
    if (const Value* collide = entries[g].find("collide")) touches[g] = read_touched(*collide, names);
  for (std::size_t g = 0; g < scene.groups.size(); ++g) {
    const BodyGroup& group = scene.groups[g];
    const std::uint64_t own = names.bit_of(group.name);
    scene.touch_rules.add({group.first, own, touches[g]});
    for (const Id id : group.untouched) scene.touch_rules.add({id, 0, 0}), scene.touch_rules.add({id + 1, own, touches[g]});
  }
}

}  // namespace unibody
