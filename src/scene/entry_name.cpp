#include "scene/entry_name.hpp"

#include <algorithm>
#include <vector>

#include "core/text.hpp"

namespace unibody {

// Those of bodies stand first, and each of the others has constraints.
std::span<const BodyGroup> entries_of(const Scene& scene, Entries among) {
  const std::span<const BodyGroup> all = scene.groups;
  return among == Entries::all ? all : all.first(all.size() - scene.constraint_groups.size());
}

void fail_without_entry(const Value& value, const std::string& name, const Scene& scene, Entries among,
                        const std::string& expected) {
  std::vector<std::string> names;
  for (const BodyGroup& group : entries_of(scene, among)) names.push_back(group.name);
  const std::string of = among == Entries::bodies ? " of bodies" : "";
  value.fail(value.found() + ", a name that no entry" + of + " has" + did_you_mean(name, names), expected);
}

const BodyGroup& entry_named(const Value& value, const std::string& name, const Scene& scene, Entries among,
                             const std::string& expected) {
  const std::span<const BodyGroup> entries = entries_of(scene, among);
  const auto is_named = [&](const BodyGroup& group) { return !name.empty() && group.name == name; };
  const auto count = std::ranges::count_if(entries, is_named);
  if (count == 0) fail_without_entry(value, name, scene, among, expected);
  if (count > 1) value.fail(value.found() + ", the name of " + std::to_string(count) + " entries", expected);
  return *std::ranges::find_if(entries, is_named);
}

}  // namespace unibody
