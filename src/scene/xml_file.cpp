#include "scene/xml_file.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "core/text.hpp"
#include "meshes/mesh_file.hpp"

namespace unibody {

using pugi::xml_node;

XmlFile::XmlFile(const std::string& path, const std::string& what) : path_(path), bytes_(read_bytes(path, what)) {
  const pugi::xml_parse_result result =
      document_.load_buffer(bytes_.data(), bytes_.size(), pugi::parse_minimal, pugi::encoding_utf8);
  if (!result)
    fail_at(path_, line_at(static_cast<std::size_t>(result.offset)), "bad XML (" + std::string(result.description()) + ")", what);
}

std::int64_t XmlFile::line_at(std::size_t offset) const {
  return 1 + std::count(bytes_.begin(), bytes_.begin() + static_cast<std::ptrdiff_t>(std::min(offset, bytes_.size())), '\n');
}

std::int64_t XmlFile::line_of(const xml_node& node) const {
  return line_at(static_cast<std::size_t>(std::max<std::ptrdiff_t>(0, node.offset_debug())));
}

void XmlFile::fail(const xml_node& node, const std::string& found, const std::string& expected) const {
  fail_at(path_, line_of(node), found, expected);
}

std::string XmlFile::text(const xml_node& node, const char* name) const {
  const pugi::xml_attribute found = node.attribute(name);
  if (!found) fail(node, "<" + std::string(node.name()) + "> without " + name, "one");
  return found.value();
}

xml_node XmlFile::child(const xml_node& node, const char* name) const {
  const xml_node found = node.child(name);
  if (!found) fail(node, "no <" + std::string(name) + "> in <" + node.name() + ">", "one");
  return found;
}

std::vector<double> XmlFile::numbers(const xml_node& node, const char* name, std::size_t least, std::size_t most) const {
  const std::string all = text(node, name);
  std::istringstream words(all);
  std::vector<double> values;
  bool is_number = true;
  for (std::string word; is_number && words >> word;) {
    double value = 0;
    is_number = parse(std::string_view(word), value) && std::isfinite(value);
    values.push_back(value);
  }
  if (is_number && values.size() >= least && values.size() <= most) return values;
  const std::string count = least == most ? std::to_string(most) : std::to_string(least) + " to " + std::to_string(most);
  fail(node, std::string(name) + " " + quote(all), most == 1 ? "a number" : count + " numbers");
}

double XmlFile::number(const xml_node& node, const char* name, double without) const {
  return node.attribute(name) ? number(node, name) : without;
}

double XmlFile::positive(const xml_node& node, const char* name) const {
  const double value = number(node, name);
  if (!(value > 0)) fail(node, std::string(name) + " " + quote(text(node, name)), "a number > 0");
  return value;
}

double XmlFile::not_negative(const xml_node& node, const char* name) const {
  const double value = number(node, name, 0);
  if (!(value >= 0)) fail(node, std::string(name) + " " + quote(text(node, name)), "a number >= 0");
  return value;
}

Vec3 XmlFile::vector(const xml_node& node, const char* name) const {
  const std::vector<double> v = numbers(node, name, 3, 3);
  return {v[0], v[1], v[2]};
}

}  // namespace unibody
