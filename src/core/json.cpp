#include "core/json.hpp"

#include <array>
#include <cmath>
#include <cstdio>

namespace unibody {

namespace {

std::string quoted(std::string_view text) {
  std::string result = "\"";
  for (const char c : text) {
    std::array<char, 8> escape{};
    if (c == '"' || c == '\\')
      result += {'\\', c};
    else if (c == '\n')
      result += "\\n";
    else if (c == '\t')
      result += "\\t";
    else if (static_cast<unsigned char>(c) < 0x20)
      std::snprintf(escape.data(), escape.size(), "\\u%04x", static_cast<unsigned>(c)), result += escape.data();
    else
      result += c;
  }
  return result + '"';
}

}  // namespace

Json::Json(double value) : text_("null") {
  if (!std::isfinite(value)) return;
  std::array<char, 40> text{};
  std::snprintf(text.data(), text.size(), "%.17g", value);
  text_ = text.data();
}

Json::Json(std::string_view value) : text_(quoted(value)) {}

Json& Json::set(std::string_view key, const Json& value) {
  keys_.push_back(quoted(key)), values_.push_back(value);
  return *this;
}

Json& Json::push(const Json& value) {
  values_.push_back(value);
  return *this;
}

std::string Json::text(int indent) const {
  if (kind_ == 0) return text_;
  const char end = kind_ == '{' ? '}' : ']';
  std::string result(1, kind_);
  for (std::size_t k = 0; k < values_.size(); ++k) {
    result += k == 0 ? "\n" : ",\n";
    result.append(static_cast<std::size_t>(indent) + 2, ' ');
    if (kind_ == '{') result += keys_[k] + ": ";
    result += values_[k].text(indent + 2);
  }
  if (!values_.empty()) result.append(1, '\n').append(static_cast<std::size_t>(indent), ' ');
  return result + end;
}

}  // namespace unibody
