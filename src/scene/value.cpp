#include "scene/value.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "core/errors.hpp"
#include "core/text.hpp"

namespace unibody {

namespace {

std::string a_number(const Range& range) { return (range.text().empty() ? "a finite number" : "a number") + range.text(); }

std::string with_unit(const std::string& unit) { return unit.empty() ? "" : " (" + unit + ")"; }

// The whole text as a number: no blanks, no hexadecimal digits, '.' whatever the locale.
template <class Number>
bool parse(const std::string& text, Number& number) {
  const char* begin = text.data();
  const char* end = begin + text.size();
  if (begin != end && *begin == '+' && begin + 1 != end && *(begin + 1) != '-') ++begin;
  const auto result = std::from_chars(begin, end, number);
  return result.ec == std::errc() && result.ptr == end && begin != end;
}

std::string shortened(const std::string& text) {
  const auto end = std::min(text.find('\n'), std::size_t{60});
  return text.size() > end ? text.substr(0, end) + "..." : text;
}

}  // namespace

std::string Range::text() const {
  const bool has_low = low > -1e308, has_high = high < 1e308;
  if (has_low && has_high)
    return std::string(" in ") + (low_open ? "(" : "[") + number_text(low) + ", " + number_text(high) + (high_open ? ")" : "]");
  if (has_low) return (low_open ? " > " : " >= ") + number_text(low);
  if (has_high) return (high_open ? " < " : " <= ") + number_text(high);
  return "";
}

const Value* Value::find(std::string_view name) const {
  for (const auto& [child_key, child] : children)
    if (child_key == name) return &child;
  return nullptr;
}

const Value& Value::need(std::string_view name, const std::string& expected) const {
  const Value* value = find(name);
  if (value == nullptr) fail_missing(std::string(name), expected);
  return *value;
}

void Value::fail(const std::string& what, const std::string& expected) const {
  std::string where = *origin;
  if (line > 0) where += ":" + std::to_string(line);
  const std::string subject = key.empty() ? "" : " key '" + key + "':";
  throw InputError(one_line(where + ":" + subject + " found " + what + ", expected " + expected));
}

void Value::fail_missing(const std::string& child, const std::string& expected) const {
  Value absent;
  absent.origin = origin;
  absent.line = line;
  absent.key = key.empty() ? child : key + "." + child;
  absent.fail("nothing", expected);
}

std::string Value::found() const {
  switch (kind) {
    case Kind::nothing:
      return "nothing";
    case Kind::scalar:
      return quoted ? std::string("'").append(shortened(text)).append("'") : shortened(text);
    case Kind::map:
      return "a map";
    case Kind::list:
      break;
  }
  const bool simple = std::all_of(entries.begin(), entries.end(), [](const Value& v) { return v.kind == Kind::scalar; });
  if (entries.empty() || entries.size() > 6 || !simple) return "a list of " + std::to_string(entries.size());
  std::string list_text;
  for (const Value& entry : entries) list_text += (list_text.empty() ? "[" : ", ") + entry.found();
  return list_text + "]";
}

double Value::number(const Range& range, const std::string& unit) const {
  double x = 0;
  const bool good = kind == Kind::scalar && !quoted && parse(text, x) && std::isfinite(x) && range.contains(x);
  if (!good) fail_expected(a_number(range) + with_unit(unit));
  return x;
}

std::int64_t Value::integer(std::int64_t low, std::int64_t high) const {
  std::int64_t i = 0;
  const bool good = kind == Kind::scalar && !quoted && parse(text, i) && i >= low && i <= high;
  if (!good && parse(text, i) && i > high) fail_expected("an integer <= " + std::to_string(high));
  if (!good) fail_expected("an integer >= " + std::to_string(low));
  return i;
}

bool Value::boolean() const {
  if (kind != Kind::scalar || quoted || (text != "true" && text != "false")) fail_expected("true or false");
  return text == "true";
}

const std::string& Value::string(const std::string& what) const {
  if (kind != Kind::scalar || text.empty()) fail_expected(what);
  return text;
}

std::size_t Value::choice(const std::vector<std::string>& names) const {
  const auto it = std::find(names.begin(), names.end(), text);
  if (kind != Kind::scalar) fail_expected(one_of(names));
  if (it == names.end()) fail(found() + did_you_mean(text, names), one_of(names));
  return static_cast<std::size_t>(it - names.begin());
}

std::vector<double> Value::numbers(std::size_t count, const Range& range, const std::string& unit) const {
  if (kind != Kind::list || entries.size() != count)
    fail_expected("a list of " + std::to_string(count) + " number" + (count == 1 ? "" : "s") + range.text() + with_unit(unit));
  std::vector<double> result;
  for (const Value& entry : entries) result.push_back(entry.number(range, unit));
  return result;
}

Vec3 Value::vector(const Range& range, const std::string& unit) const {
  const auto x = numbers(3, range, unit);
  return {x[0], x[1], x[2]};
}

Vec3 Value::unit_vector() const {
  const Vec3 v = vector(any_number, "");
  if (!(std::abs(v.norm() - 1) <= 1e-3)) fail(found() + " of length " + number_text(v.norm()), "a vector of length 1");
  return v.normalized();
}

const std::vector<Value>& Value::list(const std::string& what) const {
  if (kind != Kind::list || entries.empty()) fail_expected("a list of " + what);
  return entries;
}

const Value& Value::map(const std::vector<std::string>& keys) const {
  if (kind != Kind::map) fail_expected("a map with the keys " + one_of(keys));
  for (const auto& [name, child] : children)
    if (std::find(keys.begin(), keys.end(), name) == keys.end())
      child.fail("an unknown key" + did_you_mean(name, keys), one_of(keys));
  return *this;
}

void refuse_renamed(const Value& map, std::span<const RenamedKey> renamed) {
  for (const RenamedKey& key : renamed)
    if (const Value* old = map.find(key.before))
      old->fail("the former name of a key", std::string(key.now) + ", its name since version 0.2");
}

}  // namespace unibody
