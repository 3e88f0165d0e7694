#include "scene/schema.hpp"

#include <algorithm>

#include "scene/sections.hpp"
#include "scene/settings.hpp"

namespace unibody {

namespace {

// The tables of all maps of a scene, each once, before those of the maps that it may hold.
void collect(const Keys& table, std::vector<KeysOf>& found) {
  const auto visit = [&](const std::vector<KeysOf>& tables) {
    for (const KeysOf inner : tables)
      if (std::ranges::find(found, inner) == found.end()) {
        found.push_back(inner);
        collect(inner(), found);
      }
  };
  for (const Key& key : table.keys) visit(key.maps);
  visit(table.types);
}

Json schema_of(const Keys& table) {
  Json properties = Json::object();
  std::vector<std::string> required;
  for (const Key& key : table.keys) {
    const std::string unit = key.unit.empty() ? "" : " (" + key.unit + ")";
    const std::string text = key.about + unit + "; " + (key.without.is_needed ? "" : "default: ") + key.without.text;
    // A reference stands alone: what is beside it does not count.
    properties.set(key.name, Json::object().set("description", text).set("allOf", Json::array().push(key.schema())));
    if (key.without.is_needed) required.push_back(key.name);
  }
  Json schema = Json::object().set("type", "object").set("additionalProperties", false).set("properties", properties);
  if (!required.empty()) schema.set("required", keys::texts(required));
  if (table.restrict_schema) table.restrict_schema(schema);
  return schema.set("description", table.about);
}

// What a key may be, without the unit, which has a column of its own.
std::string values_of(const Key& key) {
  const std::string unit = " (" + key.unit + ")";
  std::string words = key.words.ends_with(unit) ? key.words.substr(0, key.words.size() - unit.size()) : key.words;
  if (key.high > key.low && key.high <= 10'000'000) words += ", <= " + std::to_string(key.high);
  return words;
}

std::string table_of(const Keys& table) {
  std::string text = "\n### " + table.name + "\n\n" + table.about +
                     "\n\n| key | unit | default | values | what it says |\n|---|---|---|---|---|\n";
  for (const Key& key : table.keys)
    text += "| `" + key.name + "` | " + key.unit + " | " + key.without.text + " | " + values_of(key) + " | " + key.about + " |\n";
  return text;
}

}  // namespace

std::string scene_schema() {
  std::vector<KeysOf> tables;
  collect(scene_keys(), tables);
  Json definitions = Json::object();
  for (const KeysOf table : tables) definitions.set(table().name, schema_of(table()));
  return schema_of(scene_keys())
             .set("$schema", "http://json-schema.org/draft-07/schema#")
             .set("title", "A scene of Unibody")
             .set("definitions", definitions)
             .text() +
         "\n";
}

std::string keys_reference() {
  std::string text = "# The keys of a scene file\n\n## Settings\n\nThe keys of the sections `time`, `output` and `solver`.\n\n" +
                     settings_table() + "\n## Sections and entries\n";
  text += table_of(scene_keys());
  std::vector<KeysOf> tables;
  collect(scene_keys(), tables);
  for (const KeysOf table : tables)
    if (table().in_reference) text += table_of(table());
  return text;
}

}  // namespace unibody
