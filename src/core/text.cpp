#include "core/text.hpp"

#include <algorithm>
#include <array>
#include <cstdio>

namespace unibody {

std::string one_line(std::string message) {
  for (char& c : message)
    if (static_cast<unsigned char>(c) < ' ' || c == 127) c = '?';
  return message;
}

std::string number_text(double x, int digits) {
  std::array<char, 40> text{};
  std::snprintf(text.data(), text.size(), "%.*g", digits, x);
  return text.data();
}

std::string exponent_text(double x) {
  std::array<char, 40> text{};
  std::snprintf(text.data(), text.size(), "%.2e", x);
  return text.data();
}

std::string one_of(const std::vector<std::string>& names) {
  std::string text;
  for (std::size_t i = 0; i < names.size(); ++i) text += (i == 0 ? "" : i + 1 == names.size() ? " or " : ", ") + names[i];
  return text;
}

namespace {

// The least number of letters to leave out, add, replace or exchange with their neighbours (optimal string alignment).
std::size_t edits(const std::string& a, const std::string& b) {
  std::vector<std::vector<std::size_t>> d(a.size() + 1, std::vector<std::size_t>(b.size() + 1));
  for (std::size_t i = 0; i <= a.size(); ++i)
    for (std::size_t j = 0; j <= b.size(); ++j) {
      if (i == 0 || j == 0) {
        d[i][j] = i + j;
        continue;
      }
      d[i][j] = std::min({d[i - 1][j] + 1, d[i][j - 1] + 1, d[i - 1][j - 1] + (a[i - 1] != b[j - 1])});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1]) d[i][j] = std::min(d[i][j], d[i - 2][j - 2] + 1);
    }
  return d[a.size()][b.size()];
}

}  // namespace

std::string did_you_mean(const std::string& written, const std::vector<std::string>& names) {
  constexpr std::size_t longest = 64;  // what is longer is no name
  if (written.size() > longest) return "";
  std::size_t least = std::max<std::size_t>(1, written.size() / 3) + 1;
  std::string nearest;
  for (const std::string& name : names)
    if (const std::size_t n = edits(written, name); n < least && n < name.size()) least = n, nearest = name;
  return nearest.empty() ? "" : " (did you mean " + nearest + "?)";
}

}  // namespace unibody
