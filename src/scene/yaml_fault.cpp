#include "scene/yaml_fault.hpp"

#include <algorithm>
#include <sstream>
#include <vector>

namespace unibody {

namespace {

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

std::string start_of(const std::string& line) { return line.substr(0, std::min(line.find_first_not_of(" \t"), line.size())); }

bool is_empty(const std::string& line) {
  const auto first = line.find_first_not_of(" \t\r");
  return first == std::string::npos || line[first] == '#';
}

// The indentations that the lines above leave open: a line may have one of these, or a larger one where the last line asks for
// it.
std::vector<std::size_t> open_indentations(const std::vector<std::string>& lines, std::size_t end) {
  std::vector<std::size_t> open;
  const auto add = [&](std::size_t spaces) {
    while (!open.empty() && open.back() >= spaces) open.pop_back();
    open.push_back(spaces);
  };
  for (std::size_t k = 0; k < end; ++k) {
    if (is_empty(lines[k])) continue;
    std::size_t spaces = start_of(lines[k]).size();
    add(spaces);
    while (lines[k].compare(spaces, 2, "- ") == 0) {  // what follows on the dash has an indentation of its own
      spaces = std::min(lines[k].find_first_not_of(' ', spaces + 1), lines[k].size());
      open.push_back(spaces);
    }
  }
  return open;
}

std::string spaces_text(std::size_t count) { return std::to_string(count) + (count == 1 ? " space" : " spaces"); }

// Whether the last line above asks for a deeper one: it ends with a key or a dash.
bool asks_for_more(const std::vector<std::string>& lines, std::size_t at) {
  while (at > 0 && is_empty(lines[at - 1])) --at;
  if (at == 0) return true;
  std::string last = lines[at - 1].substr(0, lines[at - 1].find(" #"));
  last.erase(last.find_last_not_of(" \t\r") + 1);
  return last.ends_with(':') || last.ends_with('-');
}

std::string wrong_indentation(const std::vector<std::string>& lines, std::size_t at) {
  const std::size_t here = start_of(lines[at]).size();
  const std::vector<std::size_t> open = open_indentations(lines, at);
  if (open.empty() || std::ranges::find(open, here) != open.end()) return {};
  if (here > open.back() && asks_for_more(lines, at)) return {};
  std::string allowed;
  for (std::size_t k = 0; k < open.size(); ++k)
    allowed += (k == 0 ? "" : k + 1 == open.size() ? " or " : ", ") + std::to_string(open[k]);
  return "the line begins with " + spaces_text(here) + ", expected " + allowed + " as lines above it";
}

// The last bracket before the end of the text that no other closes, where there is one. Texts in quotes and comments may hold
// any.
std::string unclosed_bracket(const std::vector<std::string>& lines) {
  std::vector<std::pair<char, std::size_t>> open;
  char quote = 0;
  for (std::size_t k = 0; k < lines.size(); ++k)
    for (std::size_t c = 0; c < lines[k].size(); ++c) {
      const char x = lines[k][c];
      if (quote != 0) {
        if (x == quote) quote = 0;
      } else if (x == '"' || x == '\'') {
        if (c == 0 || std::string_view(" [{,:").find(lines[k][c - 1]) != std::string_view::npos) quote = x;
      } else if (x == '#' && (c == 0 || lines[k][c - 1] == ' ')) {
        break;
      } else if (x == '{' || x == '[') {
        open.emplace_back(x, k + 1);
      } else if ((x == '}' || x == ']') && !open.empty()) {
        open.pop_back();
      }
    }
  if (open.empty()) return {};
  const auto [bracket, line] = open.back();
  return std::string("the '") + bracket + "' of line " + std::to_string(line) + " is not closed, expected a '" +
         (bracket == '{' ? '}' : ']') + "'";
}

std::string cause(const std::vector<std::string>& lines, std::size_t at, const std::string& message) {
  if (start_of(lines[at]).find('\t') != std::string::npos)
    return "the line begins with a tab, expected spaces: YAML takes no tabs there";
  if (message.find("flow not found") != std::string::npos) return unclosed_bracket(lines);
  if (std::string indentation = wrong_indentation(lines, at); !indentation.empty()) return indentation;
  const auto first = lines[at].find(": ");
  if (message == "illegal map value" && first != std::string::npos && lines[at].find(": ", first + 2) != std::string::npos)
    return "the line has a second ': ', expected quotes around a text that holds one";
  return {};
}

}  // namespace

std::string yaml_fault(const std::string& text, int line, const std::string& message) {
  const std::vector<std::string> lines = lines_of(text);
  if (line < 1 || lines.empty()) return message;
  const std::size_t at = std::min(static_cast<std::size_t>(line), lines.size()) - 1;  // the text's end is behind its last line
  const std::string found = cause(lines, at, message);
  return found.empty() ? message : found + " (" + message + ")";
}

}  // namespace unibody
