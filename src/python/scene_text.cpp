#include "python/scene_text.hpp"

#include <array>
#include <charconv>
#include <cmath>

#include "core/errors.hpp"

namespace unibody {

namespace {

namespace py = pybind11;

// A word that YAML takes as a text whether it is quoted or not is left as it is: the scene reader knows words such as auto.
bool is_plain_word(const std::string& text) {
  const auto is_letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; };
  if (text.empty() || !is_letter(text[0])) return false;
  for (const char c : text)
    if (!is_letter(c) && !(c >= '0' && c <= '9') && c != '-' && c != '.') return false;
  return true;
}

std::string quoted(const std::string& text) {
  static constexpr char digits[] = "0123456789abcdef";
  std::string result = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') result += '\\';
    if (static_cast<unsigned char>(c) < 0x20)
      result += std::string("\\x") + digits[(c >> 4) & 15] + digits[c & 15];
    else
      result += c;
  }
  return result + '"';
}

std::string number_text(double x) {
  if (std::isnan(x)) return ".nan";
  if (std::isinf(x)) return x > 0 ? ".inf" : "-.inf";
  std::array<char, 32> text{};
  return {text.data(), std::to_chars(text.data(), text.data() + text.size(), x).ptr};
}

std::string text_of(const py::handle& value, const std::string& place, int depth);

std::string map_text(const py::dict& map, const std::string& place, int depth) {
  std::string text = "{";
  for (const auto& [key, value] : map) {
    if (!py::isinstance<py::str>(key))
      throw InputError((place.empty() ? "scene" : place) + ": found a key that is no text, expected one that is");
    const auto name = key.cast<std::string>();
    if (text.size() > 1) text += ", ";
    text +=
        (is_plain_word(name) ? name : quoted(name)) + ": " + text_of(value, place.empty() ? name : place + "." + name, depth + 1);
  }
  return text + "}";
}

std::string list_text(const py::handle& list, const std::string& place, int depth) {
  std::string text = "[";
  std::size_t i = 0;
  for (const py::handle entry : list) {
    if (i > 0) text += ", ";
    text += text_of(entry, place + "[" + std::to_string(i++) + "]", depth + 1);
  }
  return text + "]";
}

std::string text_of(const py::handle& value, const std::string& place, int depth) {
  constexpr int deepest = 60;  // the scene reader has such a bound as well; an object that holds itself has no end
  if (depth > deepest) throw InputError(place + ": found more than " + std::to_string(deepest) + " levels, expected fewer");
  if (py::isinstance<py::bool_>(value)) return value.cast<bool>() ? "true" : "false";
  if (py::isinstance<py::int_>(value)) return py::str(value).cast<std::string>();
  if (py::isinstance<py::float_>(value)) return number_text(value.cast<double>());
  if (py::isinstance<py::str>(value)) {
    const auto text = value.cast<std::string>();
    return is_plain_word(text) ? text : quoted(text);
  }
  if (py::isinstance<py::dict>(value)) return map_text(py::reinterpret_borrow<py::dict>(value), place, depth);
  if (py::isinstance<py::list>(value) || py::isinstance<py::tuple>(value)) return list_text(value, place, depth);
  if (py::hasattr(value, "tolist")) return text_of(value.attr("tolist")(), place, depth + 1);  // arrays and numbers of numpy
  throw InputError("key '" + place + "': found an object of type " +
                   py::str(py::type::of(value).attr("__name__")).cast<std::string>() +
                   ", expected a dict, list, tuple, array, number, bool or str");
}

}  // namespace

std::string scene_text(const pybind11::dict& scene) { return map_text(scene, "", 0); }

std::string value_text(const pybind11::handle& value, const std::string& place) { return text_of(value, place, 0); }

}  // namespace unibody
