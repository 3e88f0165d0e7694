// A setting of a section of the scene file, said once: from these tables come the reader and its errors, the comparison of a
// checkpoint's settings with a scene's, the list that -settings prints and the JSON schema.
#pragma once

#include <array>
#include <functional>
#include <optional>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include "core/json.hpp"
#include "scene/value.hpp"

namespace unibody {

template <class Target>
struct Setting {
  std::string key, unit;                            // unit: empty where it has none
  std::string values;                               // what it may be, in words
  std::string about;                                // what it does, in one sentence
  std::function<void(const Value&, Target&)> read;  // throws InputError
  std::function<std::string(const Target&)> write;  // its value as a scene would say it
  std::function<Json()> schema;                     // of the value alone
};

template <class Target>
using SettingList = std::vector<Setting<Target>>;

namespace settings {

std::string text_of(double x);             // with 17 digits where they are needed
Json json_of(const std::string& text);     // a number, true or false, or a text
Json schema_of(const Range& range);        // of a number
std::string words_of(const Range& range);  // "> 0", "0 to 1, without 0", "any"
std::optional<double> read_number_or_auto(const Value& value, const Range& range, const std::string& unit);
std::optional<std::int64_t> read_integer_or_auto(const Value& value, std::int64_t low, std::int64_t high);

Json schema_of(std::int64_t low, std::int64_t high);        // of an integer
std::string words_of(std::int64_t low, std::int64_t high);  // "integer >= 1, <= 10"

inline Json or_auto(const Json& number) {
  return Json::object().set("anyOf", Json::array().push(number).push(Json::object().set("const", "auto")));
}

template <class Target>
Setting<Target> number(const char* key, const char* unit, const Range& range, double Target::*member, const char* about) {
  return {key,
          unit,
          words_of(range),
          about,
          [=](const Value& v, Target& t) { t.*member = v.number(range, unit); },
          [=](const Target& t) { return text_of(t.*member); },
          [=] { return schema_of(range); }};
}

// Or `auto`, which leaves it to the program.
template <class Target>
Setting<Target> number_or_auto(const char* key, const char* unit, const Range& range, std::optional<double> Target::*member,
                               const char* about) {
  return {key,
          unit,
          "auto, or " + words_of(range),
          about,
          [=](const Value& v, Target& t) { t.*member = read_number_or_auto(v, range, unit); },
          [=](const Target& t) { return t.*member ? text_of(*(t.*member)) : "auto"; },
          [=] { return or_auto(schema_of(range)); }};
}

template <class Target, class Integer>
Setting<Target> integer(const char* key, const char* unit, std::int64_t low, std::int64_t high, Integer Target::*member,
                        const char* about) {
  return {key,
          unit,
          words_of(low, high),
          about,
          [=](const Value& v, Target& t) { t.*member = static_cast<Integer>(v.integer(low, high)); },
          [=](const Target& t) { return std::to_string(t.*member); },
          [=] { return schema_of(low, high); }};
}

template <class Target, class Integer>
Setting<Target> integer_or_auto(const char* key, const char* unit, std::int64_t low, std::int64_t high,
                                std::optional<Integer> Target::*member, const char* about) {
  return {key,
          unit,
          "auto, or " + words_of(low, high),
          about,
          [=](const Value& v, Target& t) {
            const auto found = read_integer_or_auto(v, low, high);
            t.*member = found ? std::optional(static_cast<Integer>(*found)) : std::nullopt;
          },
          [=](const Target& t) { return t.*member ? std::to_string(*(t.*member)) : "auto"; },
          [=] { return or_auto(schema_of(low, high)); }};
}

template <class Target>
Setting<Target> flag(const char* key, bool Target::*member, const char* about) {
  return {key,
          "",
          "true, false",
          about,
          [=](const Value& v, Target& t) { t.*member = v.boolean(); },
          [=](const Target& t) { return t.*member ? "true" : "false"; },
          [] { return Json::object().set("type", "boolean"); }};
}

Json schema_of(const std::vector<std::string>& names);  // of a choice
std::string words_of(const std::vector<std::string>& names);

// An enumeration whose values are the places of their names.
template <class Target, class Enum, std::size_t n>
Setting<Target> choice(const char* key, const std::array<std::string_view, n>& names, Enum Target::*member, const char* about) {
  const std::vector<std::string> list(names.begin(), names.end());
  return {key,
          "",
          words_of(list),
          about,
          [=](const Value& v, Target& t) { t.*member = static_cast<Enum>(v.choice(list)); },
          [=](const Target& t) { return list[static_cast<std::size_t>(t.*member)]; },
          [=] { return schema_of(list); }};
}

}  // namespace settings

template <class Target>
void read_settings(const Value& value, const SettingList<Target>& list, Target& target) {
  std::vector<std::string> keys;
  for (const auto& setting : list) keys.push_back(setting.key);
  value.map(keys);
  for (const auto& setting : list)
    if (const Value* child = value.find(setting.key)) setting.read(*child, target);
}

// "key: value" of all, a line each.
template <class Target>
std::string text_of(const SettingList<Target>& list, const Target& target) {
  std::string text;
  for (const auto& setting : list) text += setting.key + ": " + setting.write(target) + "\n";
  return text;
}

// The settings as JSON: "key (unit)" and the value of each.
template <class Target>
Json json_of(const SettingList<Target>& list, const Target& target) {
  Json values = Json::object();
  for (const auto& s : list) values.set(s.unit.empty() ? s.key : s.key + " (" + s.unit + ")", settings::json_of(s.write(target)));
  return values;
}

// A map that holds no other keys.
template <class Target>
Json schema_of(const SettingList<Target>& list) {
  Json properties = Json::object();
  const Target defaults{};
  for (const auto& setting : list) {
    const std::string unit = setting.unit.empty() ? "" : " (" + setting.unit + ")";
    const std::string text = setting.about + unit + "; default: " + setting.write(defaults);
    properties.set(setting.key, setting.schema().set("description", text));
  }
  return Json::object().set("type", "object").set("additionalProperties", false).set("properties", properties);
}

// Rows of a table in Markdown: key, unit, default, values, about.
template <class Target>
std::string rows_of(const SettingList<Target>& list, const std::string& section) {
  std::string rows;
  const Target defaults{};
  for (const auto& s : list)
    rows += "| `" + section + s.key + "` | " + s.unit + " | " + s.write(defaults) + " | " + s.values + " | " + s.about + " |\n";
  return rows;
}

}  // namespace unibody
