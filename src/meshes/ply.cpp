// Written by hand: assimp 5.2.5 crashes, or reads on without end, on files that are cut off or hold a wrong count.
#include "meshes/ply.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>

#include "meshes/corners.hpp"
#include "meshes/mesh_file.hpp"

namespace unibody {

namespace {

static_assert(std::endian::native == std::endian::little);

constexpr std::string_view a_ply = "a mesh in PLY";

struct PlyType {
  std::array<std::string_view, 2> names;
  std::size_t bytes;
  double (*value)(const char* bytes);
};

template <class Number>
double ply_number(const char* bytes) {
  Number number;
  std::memcpy(&number, bytes, sizeof number);
  return static_cast<double>(number);
}

constexpr std::array<PlyType, 8> ply_types{{{{"char", "int8"}, 1, ply_number<std::int8_t>},
                                            {{"uchar", "uint8"}, 1, ply_number<std::uint8_t>},
                                            {{"short", "int16"}, 2, ply_number<std::int16_t>},
                                            {{"ushort", "uint16"}, 2, ply_number<std::uint16_t>},
                                            {{"int", "int32"}, 4, ply_number<std::int32_t>},
                                            {{"uint", "uint32"}, 4, ply_number<std::uint32_t>},
                                            {{"float", "float32"}, 4, ply_number<float>},
                                            {{"double", "float64"}, 8, ply_number<double>}}};

struct PlyProperty {
  std::string name;
  const PlyType* type = nullptr;   // of each number
  const PlyType* count = nullptr;  // of how many there are; null: one
};

struct PlyElement {
  std::string name;
  std::int64_t count = 0;
  std::vector<PlyProperty> properties;
};

class PlyReader {
 public:
  PlyReader(const std::string& path, bool soup) : path_(path), bytes_(read_bytes(path, std::string(a_ply))), soup_(soup) {}

  TriangleMesh read() {
    read_header();
    for (const PlyElement& element : elements_)
      for (std::int64_t k = 0; k < element.count; ++k) read_record(element, k);
    for (const std::vector<double>& face : faces_) add_face(face);
    if (mesh_.triangles.empty()) fail_at(path_, 0, "no faces", std::string(a_ply));
    return std::move(mesh_);
  }

 private:
  enum class Form { text, little, big };

  [[noreturn]] void fail(const std::string& found, const std::string& expected) const { fail_at(path_, line_, found, expected); }

  // The words of the next line of the header.
  std::vector<std::string> next_line() {
    const std::size_t end = bytes_.find('\n', at_);
    ++line_;
    if (end == std::string::npos) fail("the end of the file", "end_header");
    std::vector<std::string> words;
    std::string word;
    for (const char c : bytes_.substr(at_, end - at_) + " ") {
      if (c != ' ' && c != '\t' && c != '\r')
        word += c;
      else if (!word.empty())
        words.push_back(std::move(word)), word.clear();
    }
    at_ = end + 1;
    return words;
  }

  const PlyType* type_named(const std::string& name) const {
    for (const PlyType& type : ply_types)
      if (std::ranges::find(type.names, name) != type.names.end()) return &type;
    fail(quote(name), "char, uchar, short, ushort, int, uint, float or double");
  }

  void read_header() {
    if (next_line() != std::vector<std::string>{"ply"}) fail(quote(bytes_.substr(0, at_ - 1)), "ply");
    bool has_format = false;
    while (true) {
      const std::vector<std::string> words = next_line();
      if (words.empty() || words[0] == "comment" || words[0] == "obj_info") continue;
      if (words[0] == "end_header") break;
      if (words[0] == "format" && words.size() == 3) {
        const std::array<std::string_view, 3> forms{"ascii", "binary_little_endian", "binary_big_endian"};
        const auto form = std::ranges::find(forms, words[1]);
        if (form == forms.end()) fail(quote(words[1]), "ascii, binary_little_endian or binary_big_endian");
        form_ = static_cast<Form>(form - forms.begin()), has_format = true;
      } else if (words[0] == "element" && words.size() == 3) {
        PlyElement& element = elements_.emplace_back();
        element.name = words[1];
        if (!parse(std::string_view(words[2]), element.count) || element.count < 0 || element.count > 2'147'483'647)
          fail(quote(words[2]), "a whole number from 0 to 2147483647");
      } else if (words[0] == "property" && !elements_.empty() && words.size() > 2 &&
                 words.size() == (words[1] == "list" ? 5U : 3U)) {
        PlyProperty property;
        property.name = words.back(), property.type = type_named(words[words.size() - 2]);
        if (words.size() == 5) property.count = type_named(words[2]);
        elements_.back().properties.push_back(property);
      } else {
        fail(quote(words[0]) + " with " + std::to_string(words.size() - 1) + " words", "a line of a PLY header");
      }
    }
    if (!has_format) fail("no format", "a line with the format before end_header");
    check_elements();
    line_ = 0;
  }

  void check_elements() const {
    const auto has = [&](const PlyElement& element, std::string_view name, bool list) {
      return std::ranges::any_of(element.properties,
                                 [&](const PlyProperty& p) { return p.name == name && (p.count != nullptr) == list; });
    };
    const auto element = [&](std::string_view name) -> const PlyElement& {
      const auto found = std::ranges::find(elements_, name, &PlyElement::name);
      if (found == elements_.end()) fail("no element " + std::string(name), "one");
      return *found;
    };
    for (const char* name : {"x", "y", "z"})
      if (!has(element("vertex"), name, false)) fail("no " + std::string(name) + " of the element vertex", "one");
    if (!has(element("face"), "vertex_indices", true) && !has(element("face"), "vertex_index", true))
      fail("no list vertex_indices of the element face", "one");
  }

  double next(const PlyType& type, const std::string& what, std::int64_t k) {
    const auto where = [&] { return " in " + what + " " + std::to_string(k + 1); };
    if (form_ == Form::text) {
      constexpr std::string_view blanks = " \t\r\n";
      at_ = std::min(bytes_.find_first_not_of(blanks, at_), bytes_.size());
      const std::size_t end = std::min(bytes_.find_first_of(blanks, at_), bytes_.size());
      if (at_ == bytes_.size()) fail("the end of the file" + where(), "a number");
      double value = 0;
      const std::string_view word = std::string_view(bytes_).substr(at_, end - at_);
      if (!parse(word, value)) fail(quote(word) + where(), "a number");
      at_ = end;
      return value;
    }
    if (bytes_.size() - at_ < type.bytes) fail("the end of the file" + where(), "a number");
    std::array<char, 8> one{};
    std::memcpy(one.data(), bytes_.data() + at_, type.bytes);
    if (form_ == Form::big) std::reverse(one.data(), one.data() + type.bytes);
    at_ += type.bytes;
    return type.value(one.data());
  }

  void read_record(const PlyElement& element, std::int64_t k) {
    const bool is_vertex = element.name == "vertex", is_face = element.name == "face";
    Vec3 place = Vec3::Zero();
    for (const PlyProperty& property : element.properties) {
      double count = 1;
      if (property.count != nullptr) count = next(*property.count, element.name, k);
      if (!(count >= 0) || count != std::floor(count) || count > static_cast<double>(bytes_.size()))
        fail("a list of " + std::to_string(count) + " numbers in " + element.name + " " + std::to_string(k + 1),
             "a number of them");
      std::vector<double> values;
      for (double i = 0; i < count; ++i) values.push_back(next(*property.type, element.name, k));
      if (is_vertex && property.count == nullptr && property.name.size() == 1 && property.name[0] >= 'x' &&
          property.name[0] <= 'z')
        place[property.name[0] - 'x'] = values[0];
      if (is_face && property.count != nullptr && (property.name == "vertex_indices" || property.name == "vertex_index"))
        faces_.push_back(std::move(values));
    }
    if (!is_vertex) return;
    if (!place.allFinite()) fail("no finite place in vertex " + std::to_string(k + 1), "finite numbers (m)");
    mesh_.nodes.push_back(place);
  }

  void add_face(const std::vector<double>& nodes) {
    const std::string where = " in face " + std::to_string(++face_);
    std::vector<std::int32_t> numbers;
    std::vector<Vec3> places;
    for (const double node : nodes) {
      if (!(node >= 0 && node < static_cast<double>(mesh_.nodes.size()) && node == std::floor(node)))
        fail("node " + std::to_string(node) + where, "a node that is there, from 0");
      numbers.push_back(static_cast<std::int32_t>(node)), places.push_back(mesh_.nodes[static_cast<std::size_t>(node)]);
    }
    if (numbers.size() < 3) fail(std::to_string(numbers.size()) + " nodes" + where, "three or more");
    std::vector<std::int32_t> sorted = numbers;
    std::ranges::sort(sorted);
    if (!soup_ && std::ranges::adjacent_find(sorted) != sorted.end()) fail("a node twice" + where, "different nodes");
    if (numbers.size() > 3 && !is_convex(places)) fail("a face that isn't convex" + where, "triangles or convex faces");
    for (std::size_t k = 2; k < numbers.size(); ++k) mesh_.triangles.push_back({numbers[0], numbers[k - 1], numbers[k]});
  }

  const std::string& path_;
  const std::string bytes_;
  const bool soup_;
  std::size_t at_ = 0;
  std::int64_t line_ = 0, face_ = 0;
  Form form_ = Form::text;
  std::vector<PlyElement> elements_;
  std::vector<std::vector<double>> faces_;
  TriangleMesh mesh_;
};

}  // namespace

TriangleMesh read_ply(const std::string& path, bool soup) { return PlyReader(path, soup).read(); }

}  // namespace unibody
