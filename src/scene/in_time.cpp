#include "scene/in_time.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "scene/scene.hpp"

namespace unibody {

namespace {

const Keys& sine_keys() {
  static const Keys table{
      "sine",
      "A sine of the time, in the unit of the value that it stands for: mean + amplitude sin(2 pi frequency t "
      "+ phase).",
      {keys::number("amplitude", "", any_number, needed, "the most that the value is above its mean"),
       keys::number("frequency", "Hz", not_negative, needed, "periods in a second"),
       keys::number("phase", "degrees", any_number, 0, "phase at time 0"),
       keys::number("mean", "", any_number, 0, "the middle value")}};
  return table;
}

Json row_schema() { return keys::list_of(keys::of_type("number")); }

Keys table_keys(const char* name, const char* about, const char* row, const Without& without) {
  return {name,
          about,
          {keys::list("table", "", row, without, "rows of a time (s), later than that of the row before, and what holds then",
                      row_schema),
           keys::choice("between", {"linear", "steps", "smooth"}, "linear",
                        "what holds between two rows: a line; the value of the row before; a curve without slope at the rows"),
           keys::flag("periodic", false, "the table begins anew after its last row")}};
}

std::string in_unit(const std::string& unit) { return unit.empty() ? "" : " (" + unit + ")"; }

// The rows of a table: a time and then some values, the times ascending.
std::vector<std::vector<double>> read_rows(const Value& table, std::size_t values, const Range& range, const std::string& unit) {
  const std::string names = values == 1 ? "value" : "x, y, z", row = "[time (s), " + names + in_unit(unit) + "]";
  std::vector<std::vector<double>> rows;
  for (const Value& entry : table.list("rows " + row)) {
    if (entry.kind != Value::Kind::list || entry.entries.size() != 1 + values) entry.fail_expected("a row " + row);
    std::vector<double> numbers{entry.entries[0].number(any_number, "s")};
    for (std::size_t k = 1; k <= values; ++k) numbers.push_back(entry.entries[k].number(range, unit));
    if (!rows.empty() && !(numbers[0] > rows.back()[0]))
      entry.entries[0].fail_expected("a time after that of the row before (s)");
    rows.push_back(std::move(numbers));
  }
  return rows;
}

struct Law {
  TimeValue::Between between = TimeValue::Between::linear;
  bool periodic = false;
};

Law read_law(const KeyedMap& map, const std::vector<std::vector<double>>& rows) {
  const Law law{static_cast<TimeValue::Between>(map.choice("between")), map.flag("periodic")};
  if (law.periodic && rows.size() < 2) map.find("periodic")->fail("a periodic table of one row", "two rows or more");
  return law;
}

TimeValue column(const std::vector<std::vector<double>>& rows, std::size_t k, const Law& law, double factor) {
  const bool constant = std::ranges::all_of(rows, [&](const auto& row) { return row[k] == rows[0][k]; });
  if (constant) return factor * rows[0][k];
  std::vector<std::array<double, 2>> points;
  for (const auto& row : rows) points.push_back({row[0], factor * row[k]});
  return TimeValue::table(std::move(points), law.between, law.periodic);
}

TimeValue read_sine(const Value& sine, const Range& range, const std::string& unit, double factor) {
  const KeyedMap map(sine, sine_keys());
  const double amplitude = sine.need("amplitude", "a number" + in_unit(unit)).number(any_number, unit);
  const double middle = map.has("mean") ? map.need("mean").number(any_number, unit) : 0;
  for (const double extreme : {middle - amplitude, middle + amplitude})
    if (!range.contains(extreme)) sine.fail_expected("a sine whose values are all" + range.text() + in_unit(unit));
  return TimeValue::sine(factor * middle, factor * amplitude, map.number("frequency"), map.number("phase") * (M_PI / 180));
}

// At all times that the run comes to: the ends of its steps and times between, or as many as do not take long.
TimeValue read_expression(const Value& value, const Scene& scene, const Range& range, const std::string& unit, double factor) {
  const std::string& text = value.string("a formula of t");
  std::shared_ptr<const Expression> formula;
  try {
    formula = std::make_shared<const Expression>(text, factor, range.low, range.high);
  } catch (const std::invalid_argument& error) {
    value.fail("'" + text + "' (" + error.what() + ")", "a formula of the time t (s)" + in_unit(unit));
  }
  constexpr double most_tries = 2e5;
  const double end = static_cast<double>(scene.time.frames) * scene.time.frame;
  const double tries = std::clamp(8.0 * static_cast<double>(scene.time.frames * scene.time.substeps), 8.0, most_tries);
  double largest = 0;
  for (double k = 0; k <= tries; ++k) {
    const double time = end * (k / tries);
    try {
      largest = std::max(largest, std::abs(formula->at(time)));
    } catch (const ExpressionFault& fault) {
      value.fail(fault.found, "a number" + range.text() + in_unit(unit) + " at all times of the run");
    }
  }
  return TimeValue::expression(std::move(formula), largest);
}

const Keys& value_in_time_keys() {
  static const Keys table =
      table_keys("value_in_time", "A value that changes with the time: a table, a sine or an expression.",
                 "rows [time (s), value]", "one of the others")
          .with({"",
                 "",
                 {keys::map("sine", sine_keys, "a map with amplitude and frequency", "one of the others", "a sine of the time"),
                  keys::text("expression", "a formula of t", "one of the others", "a formula of the time t (s)")}});
  return table;
}

const Keys& vector_in_time_keys() {
  static const Keys table =
      table_keys("vector_in_time", "A vector that changes with the time.", "rows [time (s), x, y, z]", needed);
  return table;
}

}  // namespace

namespace keys {

Key number_in_time(const char* name, const char* unit, const Range& range, const Without& without, const char* about) {
  Key key = number(name, unit, range, without, about);
  key.maps = {value_in_time_keys};
  key.schema = [range] { return any_of({of_range(range), list_of(row_schema()), reference_to(value_in_time_keys)}); };
  return key;
}

Key vector_in_time(const char* name, const char* unit, const Without& without, const char* about) {
  const auto schema = [] {
    const Json component = any_of({of_type("number"), list_of(row_schema()), reference_to(value_in_time_keys)});
    return any_of({list_of(component, 3), reference_to(vector_in_time_keys)});
  };
  return other(name, unit, "a list of 3 numbers, or of values in time, or a table", without, about, schema,
               {value_in_time_keys, vector_in_time_keys});
}

}  // namespace keys

TimeValue read_in_time(const Value& value, const Scene& scene, const Range& range, const std::string& unit, double factor) {
  if (value.kind == Value::Kind::list) return column(read_rows(value, 1, range, unit), 1, {}, factor);
  if (value.kind != Value::Kind::map) return factor * value.number(range, unit);
  const KeyedMap map(value, value_in_time_keys());
  for (const char* law : {"sine", "expression"}) {
    const Value* found = map.find(law);
    if (!found) continue;
    for (const char* key : {"table", "between", "periodic", "sine", "expression"})
      if (const Value* other = map.find(key); other && other != found)
        other->fail(std::string(key) + " beside " + law, "one of table, sine and expression");
    return std::string(law) == "sine" ? read_sine(*found, range, unit, factor)
                                      : read_expression(*found, scene, range, unit, factor);
  }
  const auto rows =
      read_rows(value.need("table", "rows [time (s), value" + in_unit(unit) + "], sine or expression"), 1, range, unit);
  return column(rows, 1, read_law(map, rows), factor);
}

TimeValue read_in_time(const KeyedMap& map, std::string_view name, const Scene& scene, double factor) {
  const Key& key = map.key(name);
  return read_in_time(map.need(name), scene, key.range, key.unit, factor);
}

TimeVector read_vector_in_time(const Value& value, const Scene& scene, const std::string& unit) {
  TimeVector vector;
  if (value.kind == Value::Kind::map) {
    const KeyedMap map(value, vector_in_time_keys());
    const auto rows = read_rows(value.need("table", "rows [time (s), x, y, z" + in_unit(unit) + "]"), 3, any_number, unit);
    const Law law = read_law(map, rows);
    for (std::size_t k = 0; k < 3; ++k) vector[k] = column(rows, k + 1, law, 1);
    return vector;
  }
  if (value.kind != Value::Kind::list || value.entries.size() != 3)
    value.fail_expected("a list of 3 numbers, or of values in time, or a table" + in_unit(unit));
  for (std::size_t k = 0; k < 3; ++k) vector[k] = read_in_time(value.entries[k], scene, any_number, unit);
  return vector;
}

TimeVector read_planar_in_time(const Value& value, const Scene& scene, const std::string& unit, bool rotation) {
  const TimeVector vector = read_vector_in_time(value, scene, unit);
  for (std::size_t k = 0; k < 3 && scene.planar; ++k)
    if ((k == 1) != rotation && (vector[k].changes() || vector[k].at(0) != 0))
      value.fail_expected(rotation ? "0 as the first and third component (planar scene)"
                                   : "0 as the second component (planar scene)");
  return vector;
}

TimeVector read_planar_in_time(const KeyedMap& map, std::string_view name, const Scene& scene, bool rotation) {
  return read_planar_in_time(map.need(name), scene, map.key(name).unit, rotation);
}

bool is_vector_in_time(const Value& value) {
  return value.kind == Value::Kind::map ||
         std::ranges::any_of(value.entries, [](const Value& entry) { return entry.kind != Value::Kind::scalar; });
}

}  // namespace unibody
