// What the readers of mesh files share: whole files, words, numbers, and the form of their messages.
#pragma once

#include <charconv>
#include <cstdint>
#include <string>
#include <string_view>

namespace unibody {

// The bytes of a file. Throws InputError where there is no readable file, or an empty one; `expected` is what it should hold.
std::string read_bytes(const std::string& path, const std::string& expected);

// Throws InputError "file:line: found v, expected e"; line 0: the fault has no line.
[[noreturn]] void fail_at(const std::string& path, std::int64_t line, const std::string& found, const std::string& expected);

// The text in quotes; of a long one only its beginning.
std::string quote(std::string_view text);

// The whole word as a number, whatever the locale.
template <class Number>
bool parse(std::string_view word, Number& number) {
  if (word.size() > 1 && word[0] == '+' && word[1] != '-') word.remove_prefix(1);
  const auto result = std::from_chars(word.data(), word.data() + word.size(), number);
  return result.ec == std::errc() && result.ptr == word.data() + word.size();
}

}  // namespace unibody
