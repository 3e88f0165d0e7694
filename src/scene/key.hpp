// A key of a map in the scene file, said once: from the tables of keys come the reader and its errors, the JSON schema and the
// reference page that -settings prints. (The keys of time, output and solver, which fill a struct of settings each, are tables of
// Setting.)
#pragma once

#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/json.hpp"
#include "scene/value.hpp"

namespace unibody {

struct Keys;
using KeysOf = const Keys& (*)();  // a table, made when it is asked for first: shapes hold compounds, which hold shapes

// What holds where a key is not given.
struct Without {
  std::string text;
  double number = std::numeric_limits<double>::quiet_NaN();
  bool is_needed = false;  // the key must be there

  Without(double value);
  Without(int value) : Without(static_cast<double>(value)) {}
  Without(bool value) : text(value ? "true" : "false"), number(value ? 1 : 0) {}
  Without(const char* words) : text(words) {}
  struct Needed {};
  Without(Needed) : text("required"), is_needed(true) {}
};
inline constexpr Without::Needed needed{};

struct Key {
  std::string name, unit;  // unit: empty where it has none
  std::string words;       // what it may be, as errors say it
  Without without;
  std::string about;                    // what it says, in one sentence
  std::function<Json()> schema;         // of the value
  std::vector<KeysOf> maps = {};        // the tables of the maps that the value may hold
  Range range = {};                     // of numbers
  std::int64_t low = 0, high = 0;       // of integers
  std::size_t count = 0;                // of a list of numbers
  std::vector<std::string> names = {};  // of a choice
};

// The keys of a map.
struct Keys {
  std::string name;   // in the reference and the schema
  std::string about;  // one sentence
  std::vector<Key> keys;
  std::function<void(Json&)> restrict_schema = {};  // says in the schema which keys go together
  std::vector<KeysOf> types = {};                   // tables of its kinds, which the schema refers to
  bool in_reference = true;                         // false: the reference has it as one of the types of another

  const Key& at(std::string_view name) const;  // throws std::logic_error where there is no such key: a fault of the program
  std::vector<std::string> names() const;
  Keys with(const Keys& others) const;  // and these keys
};

namespace keys {

Key number(const char* name, const char* unit, const Range& range, const Without& without, const char* about);
Key integer(const char* name, std::int64_t low, std::int64_t high, const Without& without, const char* about);
Key flag(const char* name, bool without, const char* about);
Key text(const char* name, const char* words, const Without& without, const char* about);
Key choice(const char* name, std::vector<std::string> names, const Without& without, const char* about);
// So many numbers, or so many integers.
Key numbers(const char* name, std::size_t count, const char* unit, const Range& range, const Without& without, const char* about);
Key integers(const char* name, std::size_t count, std::int64_t low, std::int64_t high, const Without& without, const char* about);
Key vector(const char* name, const char* unit, const Without& without, const char* about);  // three numbers
Key direction(const char* name, const Without& without, const char* about);                 // a vector of length 1
Key map(const char* name, KeysOf table, const char* words, const Without& without, const char* about);
Key list_of_maps(const char* name, KeysOf table, const char* words, const Without& without, const char* about);
// A list of anything else, or a value of several forms that `schema` describes.
Key list(const char* name, const char* unit, const char* words, const Without& without, const char* about,
         const std::function<Json()>& item);
Key other(const char* name, const char* unit, const char* words, const Without& without, const char* about,
          const std::function<Json()>& schema, std::vector<KeysOf> maps = {});

Json of_type(const char* type);
Json of_range(const Range& range);                      // a number
Json list_of(const Json& item, std::size_t count = 0);  // 0: any number of them, at least one
Json reference_to(KeysOf table);                        // to the definition of a map
Json any_of(const std::vector<Json>& schemas);
Json texts(const std::vector<std::string>& list);

}  // namespace keys

// A map of the file that is read by a table.
class KeyedMap {
 public:
  // Throws InputError where the value isn't a map, or has a key that is not in the table.
  KeyedMap(const Value& value, const Keys& keys);
  KeyedMap(const Value&, Keys&&) = delete;

  const Value& value() const { return *value_; }
  const Key& key(std::string_view name) const { return keys_->at(name); }
  const Value* find(std::string_view name) const;  // null where it is not given
  const Value& need(std::string_view name) const;  // throws InputError where it is not given
  bool has(std::string_view name) const { return find(name) != nullptr; }
  // Refuses the second of these keys that is given.
  void only_one_of(std::initializer_list<const char*> names) const;
  // Refuses these keys where they are given: "no such key WHERE".
  void none_of(std::initializer_list<const char*> names, const std::string& where) const;

  // The value of a key, or what its table says holds without it.
  double number(std::string_view name) const;
  std::int64_t integer(std::string_view name) const;
  bool flag(std::string_view name) const;
  // Nothing where it is not given.
  std::optional<double> number_if(std::string_view name) const;
  // The place of the name in the table's; 0 where it is not given.
  std::size_t choice(std::string_view name) const;
  std::vector<double> numbers(std::string_view name) const;
  template <std::size_t n>
  std::array<std::int64_t, n> integers(std::string_view name) const {
    std::array<std::int64_t, n> result{};
    read_integers(name, result.data());
    return result;
  }
  Vec3 vector(std::string_view name) const;
  Vec3 direction(std::string_view name) const;
  const std::vector<Value>& list(std::string_view name) const;  // of what must be there

 private:
  void read_integers(std::string_view name, std::int64_t* result) const;

  const Value* value_;
  const Keys* keys_;
};

}  // namespace unibody
