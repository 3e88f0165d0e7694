// Just enough JSON to write a summary.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace unibody {

// A value as text. Objects keep the order in which their keys are set.
class Json {
 public:
  Json(double value);  // null unless finite
  Json(std::int64_t value) : text_(std::to_string(value)) {}
  Json(int value) : text_(std::to_string(value)) {}
  Json(bool value) : text_(value ? "true" : "false") {}
  Json(std::string_view value);
  Json(const std::string& value) : Json(std::string_view(value)) {}
  Json(const char* value) : Json(std::string_view(value)) {}
  static Json object() { return Json('{'); }
  static Json array() { return Json('['); }

  Json& set(std::string_view key, const Json& value);  // of an object
  Json& push(const Json& value);                       // to an array
  std::string text(int indent = 0) const;

 private:
  explicit Json(char kind) : kind_(kind) {}
  char kind_ = 0;
  std::string text_;
  std::vector<std::string> keys_;
  std::vector<Json> values_;
};

}  // namespace unibody
