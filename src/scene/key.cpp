#include "scene/key.hpp"

#include <algorithm>
#include <stdexcept>

#include "core/text.hpp"
#include "scene/setting.hpp"

namespace unibody {

namespace {

std::string with_unit(const std::string& text, const std::string& unit) { return unit.empty() ? text : text + " (" + unit + ")"; }

std::string a_list_of(std::size_t count, const std::string& what) { return "a list of " + std::to_string(count) + " " + what; }

Key key_of(const char* name, const char* unit, const std::string& words, const Without& without, const char* about) {
  return {.name = name, .unit = unit, .words = with_unit(words, unit), .without = without, .about = about, .schema = {}};
}

}  // namespace

Without::Without(double value) : text(settings::text_of(value)), number(value) {}

const Key& Keys::at(std::string_view key_name) const {
  const auto found = std::ranges::find(keys, key_name, &Key::name);
  if (found == keys.end()) throw std::logic_error("no key " + std::string(key_name) + " in the table of " + name);
  return *found;
}

std::vector<std::string> Keys::names() const {
  std::vector<std::string> result;
  for (const Key& key : keys) result.push_back(key.name);
  return result;
}

Keys Keys::with(const Keys& others) const {
  Keys result = *this;
  result.keys.insert(result.keys.end(), others.keys.begin(), others.keys.end());
  return result;
}

namespace keys {

Json of_type(const char* type) { return Json::object().set("type", type); }
Json of_range(const Range& range) { return settings::schema_of(range); }
Json reference_to(KeysOf table) { return Json::object().set("$ref", "#/definitions/" + table().name); }

Json list_of(const Json& item, std::size_t count) {
  Json list = of_type("array").set("items", item).set("minItems", static_cast<std::int64_t>(std::max<std::size_t>(count, 1)));
  return count > 0 ? list.set("maxItems", static_cast<std::int64_t>(count)) : list;
}

Json any_of(const std::vector<Json>& schemas) {
  Json list = Json::array();
  for (const Json& schema : schemas) list.push(schema);
  return Json::object().set("anyOf", list);
}

Json texts(const std::vector<std::string>& list) {
  Json result = Json::array();
  for (const std::string& text : list) result.push(text);
  return result;
}

Key number(const char* name, const char* unit, const Range& range, const Without& without, const char* about) {
  Key key = key_of(name, unit, "a number" + range.text(), without, about);
  key.range = range;
  key.schema = [range] { return of_range(range); };
  return key;
}

Key integer(const char* name, std::int64_t low, std::int64_t high, const Without& without, const char* about) {
  Key key = key_of(name, "", "an integer >= " + std::to_string(low), without, about);
  key.low = low, key.high = high;
  key.schema = [low, high] { return of_type("integer").set("minimum", low).set("maximum", high); };
  return key;
}

Key flag(const char* name, bool without, const char* about) {
  Key key = key_of(name, "", "true or false", without, about);
  key.schema = [] { return of_type("boolean"); };
  return key;
}

Key text(const char* name, const char* words, const Without& without, const char* about) {
  Key key = key_of(name, "", words, without, about);
  key.schema = [] { return Json::object().set("type", texts({"string", "number", "boolean"})); };  // a name may be 7, or true
  return key;
}

Key choice(const char* name, std::vector<std::string> names, const Without& without, const char* about) {
  Key key = key_of(name, "", one_of(names), without, about);
  key.names = std::move(names);
  key.schema = [list = key.names] { return Json::object().set("enum", texts(list)); };
  return key;
}

Key numbers(const char* name, std::size_t count, const char* unit, const Range& range, const Without& without,
            const char* about) {
  Key key = key_of(name, unit, a_list_of(count, (count == 1 ? "number" : "numbers") + range.text()), without, about);
  key.range = range, key.count = count;
  key.schema = [range, count] { return list_of(of_range(range), count); };
  return key;
}

Key integers(const char* name, std::size_t count, std::int64_t low, std::int64_t high, const Without& without,
             const char* about) {
  Key key = key_of(name, "", a_list_of(count, "integers >= " + std::to_string(low)), without, about);
  key.low = low, key.high = high, key.count = count;
  key.schema = [low, high, count] { return list_of(of_type("integer").set("minimum", low).set("maximum", high), count); };
  return key;
}

Key vector(const char* name, const char* unit, const Without& without, const char* about) {
  return numbers(name, 3, unit, any_number, without, about);
}

Key direction(const char* name, const Without& without, const char* about) {
  Key key = numbers(name, 3, "", any_number, without, about);
  key.words = "a vector of length 1";
  return key;
}

Key map(const char* name, KeysOf table, const char* words, const Without& without, const char* about) {
  return other(name, "", words, without, about, [table] { return reference_to(table); }, {table});
}

Key list_of_maps(const char* name, KeysOf table, const char* words, const Without& without, const char* about) {
  return other(name, "", words, without, about, [table] { return list_of(reference_to(table)); }, {table});
}

Key list(const char* name, const char* unit, const char* words, const Without& without, const char* about,
         const std::function<Json()>& item) {
  return other(name, unit, words, without, about, [item] { return list_of(item()); });
}

Key other(const char* name, const char* unit, const char* words, const Without& without, const char* about,
          const std::function<Json()>& schema, std::vector<KeysOf> maps) {
  Key key = key_of(name, "", words, without, about);
  key.unit = unit, key.schema = schema, key.maps = std::move(maps);
  return key;
}

}  // namespace keys

KeyedMap::KeyedMap(const Value& value, const Keys& keys) : value_(&value), keys_(&keys) {
  const auto is_known = [&](const auto& child) {
    return std::ranges::find(keys.keys, child.first, &Key::name) != keys.keys.end();
  };
  if (value.kind != Value::Kind::map || !std::ranges::all_of(value.children, is_known)) value.map(keys.names());  // which throws
}

const Value* KeyedMap::find(std::string_view name) const { return value_->find(key(name).name); }
const Value& KeyedMap::need(std::string_view name) const { return value_->need(name, key(name).words); }

void KeyedMap::only_one_of(std::initializer_list<const char*> names) const {
  const Value* first = nullptr;
  std::string text;
  std::vector<std::string> all(names.begin(), names.end());
  for (const char* name : names) {
    const Value* given = find(name);
    if (given && first) {
      const std::string list = one_of(all);
      given->fail(std::string(name) + " beside " + text,
                  "only one of " + list.substr(0, list.rfind(" or ")) + " and " + all.back());
    }
    if (given) first = given, text = name;
  }
}

void KeyedMap::none_of(std::initializer_list<const char*> names, const std::string& where) const {
  for (const char* name : names)
    if (const Value* given = value_->find(name)) given->fail_expected("no such key " + where);
}

double KeyedMap::number(std::string_view name) const {
  const Key& of = key(name);
  if (!of.without.is_needed && !has(name)) return of.without.number;
  return need(name).number(of.range, of.unit);
}

std::optional<double> KeyedMap::number_if(std::string_view name) const {
  const Value* given = find(name);
  return given ? std::optional(given->number(key(name).range, key(name).unit)) : std::nullopt;
}

std::int64_t KeyedMap::integer(std::string_view name) const {
  const Key& of = key(name);
  if (!of.without.is_needed && !has(name)) return static_cast<std::int64_t>(of.without.number);
  return need(name).integer(of.low, of.high);
}

bool KeyedMap::flag(std::string_view name) const { return has(name) ? need(name).boolean() : key(name).without.number != 0; }

std::size_t KeyedMap::choice(std::string_view name) const {
  const Key& of = key(name);
  if (!of.without.is_needed && !has(name)) return 0;
  return need(name).choice(of.names);
}

std::vector<double> KeyedMap::numbers(std::string_view name) const {
  const Key& of = key(name);
  return need(name).numbers(of.count, of.range, of.unit);
}

Vec3 KeyedMap::vector(std::string_view name) const {
  const auto x = numbers(name);
  return {x[0], x[1], x[2]};
}

Vec3 KeyedMap::direction(std::string_view name) const { return need(name).unit_vector(); }

const std::vector<Value>& KeyedMap::list(std::string_view name) const { return need(name).list(key(name).words); }

void KeyedMap::read_integers(std::string_view name, std::int64_t* result) const {
  const Key& of = key(name);
  const Value& value = need(name);
  if (value.kind != Value::Kind::list || value.entries.size() != of.count) value.fail_expected(of.words);
  for (std::size_t k = 0; k < of.count; ++k) result[k] = value.entries[k].integer(of.low, of.high);
}

}  // namespace unibody
