// The scene file as a tree of values that know where they stand: every fault names file, line, key, the value and what was
// expected.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/types.hpp"
#include "scene/scene.hpp"

namespace unibody {

// The numbers that are allowed, for example {0, 1, true} for (0, 1].
struct Range {
  double low = -1e308, high = 1e308;
  bool low_open = false, high_open = false;

  bool contains(double x) const { return (low_open ? x > low : x >= low) && (high_open ? x < high : x <= high); }
  std::string text() const;  // " > 0", " in [0, 0.5]", "" for any number
};

inline constexpr Range any_number{};
inline constexpr Range positive{0, 1e308, true};
inline constexpr Range not_negative{0};

class Value {
 public:
  enum class Kind { nothing, scalar, list, map };

  Kind kind = Kind::nothing;
  std::string text;                                     // of a scalar
  bool quoted = false;                                  // a quoted scalar is a string, whatever it holds
  std::vector<Value> entries;                           // of a list
  std::vector<std::pair<std::string, Value>> children;  // of a map, in the order of the file
  std::string key;                                      // full path: bodies[2].mass
  std::shared_ptr<const std::string> origin;            // the file, or "-set path=value"
  int line = 0;                                         // 1 is the first; 0: not from the file

  const Value* find(std::string_view name) const;                               // child of a map; null where there is none
  const Value& need(std::string_view name, const std::string& expected) const;  // the same, which must be there

  [[noreturn]] void fail(const std::string& found, const std::string& expected) const;
  [[noreturn]] void fail_expected(const std::string& expected) const { fail(found(), expected); }
  [[noreturn]] void fail_missing(const std::string& child, const std::string& expected) const;
  std::string found() const;  // the value in few words

  // Typed access; each fails with a message that says what was expected. `unit` goes into that message.
  double number(const Range& range, const std::string& unit) const;
  std::int64_t integer(std::int64_t low, std::int64_t high = std::int64_t{1} << 53) const;
  bool boolean() const;
  const std::string& string(const std::string& what) const;
  std::size_t choice(const std::vector<std::string>& names) const;
  std::vector<double> numbers(std::size_t count, const Range& range, const std::string& unit) const;
  Vec3 vector(const Range& range, const std::string& unit) const;
  Vec3 unit_vector() const;  // of length 1 within 1e-3, made exact
  const std::vector<Value>& list(const std::string& what) const;
  const Value& map(const std::vector<std::string>& keys) const;  // a map that holds no other keys than these
};

// Reads a YAML file and applies the overrides. Throws InputError on a missing file, on what isn't YAML, on a key given twice.
Value load_value(const std::string& path, const std::vector<Override>& overrides);
// The same of a text that is in no file: `path` names it in errors.
Value value_of_text(const std::string& text, const std::string& path, const std::vector<Override>& overrides);

// A key that had another name before: it stops the reading with a line that names the new one.
struct RenamedKey {
  const char *before, *now;
};
void refuse_renamed(const Value& map, std::span<const RenamedKey> renamed);

}  // namespace unibody
