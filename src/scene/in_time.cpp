#include "scene/in_time.hpp"

#include <algorithm>
#include <cmath>

#include "scene/scene.hpp"

namespace unibody {

namespace {

const std::vector<std::string> betweens{"linear", "steps", "smooth"};

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

Law read_law(const Value& map, const std::vector<std::vector<double>>& rows) {
  Law law;
  if (const Value* between = map.find("between")) law.between = static_cast<TimeValue::Between>(between->choice(betweens));
  if (const Value* periodic = map.find("periodic")) {
    law.periodic = periodic->boolean();
    if (law.periodic && rows.size() < 2) periodic->fail("a periodic table of one row", "two rows or more");
  }
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
  sine.map({"amplitude", "frequency", "phase", "mean"});
  const double amplitude = sine.need("amplitude", "a number" + in_unit(unit)).number(any_number, unit);
  const double frequency = sine.need("frequency", "a number >= 0 (Hz)").number(not_negative, "Hz");
  const Value *phase = sine.find("phase"), *mean = sine.find("mean");
  const double middle = mean ? mean->number(any_number, unit) : 0;
  for (const double extreme : {middle - amplitude, middle + amplitude})
    if (!range.contains(extreme)) sine.fail_expected("a sine whose values are all" + range.text() + in_unit(unit));
  return TimeValue::sine(factor * middle, factor * amplitude, frequency,
                         phase ? phase->number(any_number, "degrees") * (M_PI / 180) : 0);
}

}  // namespace

TimeValue read_in_time(const Value& value, const Range& range, const std::string& unit, double factor) {
  if (value.kind == Value::Kind::list) return column(read_rows(value, 1, range, unit), 1, {}, factor);
  if (value.kind != Value::Kind::map) return factor * value.number(range, unit);
  value.map({"table", "between", "periodic", "sine"});
  if (const Value* sine = value.find("sine")) {
    for (const char* key : {"table", "between", "periodic"})
      if (const Value* other = value.find(key)) other->fail(std::string(key) + " beside a sine", "only a sine, or a table");
    return read_sine(*sine, range, unit, factor);
  }
  const auto rows = read_rows(value.need("table", "rows [time (s), value" + in_unit(unit) + "], or sine"), 1, range, unit);
  return column(rows, 1, read_law(value, rows), factor);
}

TimeVector read_vector_in_time(const Value& value, const std::string& unit) {
  TimeVector vector;
  if (value.kind == Value::Kind::map) {
    value.map({"table", "between", "periodic"});
    const auto rows = read_rows(value.need("table", "rows [time (s), x, y, z" + in_unit(unit) + "]"), 3, any_number, unit);
    const Law law = read_law(value, rows);
    for (std::size_t k = 0; k < 3; ++k) vector[k] = column(rows, k + 1, law, 1);
    return vector;
  }
  if (value.kind != Value::Kind::list || value.entries.size() != 3)
    value.fail_expected("a list of 3 numbers, or of values in time, or a table" + in_unit(unit));
  for (std::size_t k = 0; k < 3; ++k) vector[k] = read_in_time(value.entries[k], any_number, unit);
  return vector;
}

TimeVector read_planar_in_time(const Value& value, const Scene& scene, const std::string& unit, bool rotation) {
  const TimeVector vector = read_vector_in_time(value, unit);
  for (std::size_t k = 0; k < 3 && scene.planar; ++k)
    if ((k == 1) != rotation && (vector[k].changes() || vector[k].at(0) != 0))
      value.fail_expected(rotation ? "0 as the first and third component (planar scene)"
                                   : "0 as the second component (planar scene)");
  return vector;
}

bool is_vector_in_time(const Value& value) {
  return value.kind == Value::Kind::map ||
         std::ranges::any_of(value.entries, [](const Value& entry) { return entry.kind != Value::Kind::scalar; });
}

}  // namespace unibody
