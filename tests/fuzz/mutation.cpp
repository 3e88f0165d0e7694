#include "fuzz/mutation.hpp"

#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <string_view>
#include <vector>

namespace unibody::fuzz {

namespace {

constexpr std::array<std::string_view, 34> numbers{"0",
                                                   "-0",
                                                   "1",
                                                   "-1",
                                                   "2",
                                                   "3",
                                                   "0.5",
                                                   "-0.5",
                                                   "1e-3",
                                                   "1e3",
                                                   "1e-12",
                                                   "1e12",
                                                   "1e-40",
                                                   "1e40",
                                                   "1e308",
                                                   "-1e308",
                                                   "1e999",
                                                   "5e-324",
                                                   ".nan",
                                                   ".inf",
                                                   "-.inf",
                                                   "2147483647",
                                                   "2147483648",
                                                   "-2147483649",
                                                   "4294967296",
                                                   "9223372036854775807",
                                                   "9223372036854775808",
                                                   "0x10",
                                                   "1_000",
                                                   "'1'",
                                                   "true",
                                                   "null",
                                                   "[]",
                                                   "{}"};
constexpr std::array<std::string_view, 36> words{
    "bodies",   "shape",    "sphere",   "box",    "plane",   "mesh",   "hull",   "compound",  "cylinder",
    "capsule",  "particle", "disc",     "mass",   "density", "motion", "fixed",  "kinematic", "position",
    "velocity", "force",    "material", "joints", "hinge",   "ball",   "cloths", "grid",      "nodes",
    "threads",  "solids",   "block",    "cells",  "pins",    "solver", "name",   "auto",      "stiffness"};

std::size_t below(std::size_t n, Random& random) { return n == 0 ? 0 : static_cast<std::size_t>(random() % n); }

// Mostly one or two: of more, the first is found and the others never matter.
std::size_t changes(Random& random) { return 1 + (random() % 2) + (random() % 8 == 0 ? 2 : 0); }

bool is_of_number(char c) { return (c >= '0' && c <= '9') || c == '.' || c == '-'; }
bool is_of_word(char c) { return (c >= 'a' && c <= 'z') || c == '_'; }

// Replaces one of the runs of such characters.
template <class Is, class Choice>
void replace_run(std::string& text, Random& random, Is is, const Choice& choice) {
  std::vector<std::pair<std::size_t, std::size_t>> runs;
  for (std::size_t k = 0; k < text.size();) {
    std::size_t end = k;
    while (end < text.size() && is(text[end])) ++end;
    if (end > k) runs.emplace_back(k, end - k);
    k = std::max(end, k + 1);
  }
  if (runs.empty()) return;
  const auto [at, length] = runs[below(runs.size(), random)];
  text.replace(at, length, choice[below(choice.size(), random)]);
}

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines{""};
  for (const char c : text) {
    lines.back() += c;
    if (c == '\n') lines.emplace_back();
  }
  return lines;
}

void change_lines(std::string& text, Random& random) {
  auto lines = lines_of(text);
  const std::size_t one = below(lines.size(), random), other = below(lines.size(), random);
  switch (random() % 4) {
    case 0:
      lines.erase(lines.begin() + static_cast<std::ptrdiff_t>(one));
      break;
    case 1:
      lines.insert(lines.begin() + static_cast<std::ptrdiff_t>(other), std::string(lines[one]));
      break;
    case 2:
      std::swap(lines[one], lines[other]);
      break;
    default:
      lines[one].insert(0, 1 + random() % 4, ' ');
  }
  text.clear();
  for (const auto& line : lines) text += line;
}

void change_bytes(std::string& bytes, Random& random, std::size_t from) {
  if (bytes.size() <= from) return;
  const std::size_t at = from + below(bytes.size() - from, random), left = bytes.size() - at;
  const std::size_t length = std::min(left, std::size_t{1} << random() % 10);
  switch (random() % 8) {
    case 0:
      bytes[at] = static_cast<char>(bytes[at] ^ (1 << random() % 8));
      break;
    case 1:
      bytes[at] = static_cast<char>(random());
      break;
    case 2: {
      constexpr std::array<double, 8> reals{0, -1, 1e308, -1e-308, 4294967296.0, 1e16, 0.5, 2};
      constexpr std::array<std::uint64_t, 8> wholes{
          0, ~0ull, 1ull << 63, 0x7fffffff, 0x7ff8000000000000, 0x7ff0000000000000, 255, 1ull << 40};
      const std::size_t aligned = at / 8 * 8;
      if (aligned < from || aligned + 8 > bytes.size()) break;
      const std::uint64_t value = random() % 2 ? wholes[random() % 8] : std::bit_cast<std::uint64_t>(reals[random() % 8]);
      std::memcpy(bytes.data() + aligned, &value, 8);
      break;
    }
    case 3:
      bytes.erase(at, length);
      break;
    case 4:
      bytes.insert(at, bytes.substr(at, length));
      break;
    case 5:
      bytes.replace(at, length, length, '\0');
      break;
    case 6:
      for (std::size_t k = 0; k < std::min<std::size_t>(length, 8); ++k) bytes[at + k] = static_cast<char>(random());
      break;
    default:
      if (random() % 4 == 0) bytes.resize(at);
  }
}

}  // namespace

std::string damage_text(const std::string& text, Random& random) {
  std::string damaged = text;
  for (std::size_t n = changes(random); n > 0; --n) switch (random() % 16) {
      case 0:
        replace_run(damaged, random, is_of_word, words);
        break;
      case 1:
      case 2:
        change_lines(damaged, random);
        break;
      case 3:
        change_bytes(damaged, random, 0);
        break;
      default:
        replace_run(damaged, random, is_of_number, numbers);
    }
  return damaged;
}

std::string damage_bytes(const std::string& bytes, Random& random, std::size_t from) {
  std::string damaged = bytes;
  for (std::size_t n = changes(random); n > 0; --n) change_bytes(damaged, random, from);
  return damaged;
}

}  // namespace unibody::fuzz
