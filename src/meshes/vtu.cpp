#include "meshes/vtu.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <pugixml.hpp>

#include "core/text.hpp"
#include "meshes/mesh_file.hpp"
#include "meshes/vtu_data.hpp"

namespace unibody {

namespace {

using pugi::xml_node;

constexpr std::int64_t tetrahedron = 10;
constexpr std::int64_t most_corners = std::int64_t{1} << 48;  // so that sizes in bytes are numbers
constexpr std::string_view blanks = " \t\r\n\v\f";

// Cells without volume: points, lines, triangles, quadrangles and polygons of any order.
constexpr std::int64_t flat_cells[] = {0,  1,  2,  3,  4,  5,  6,  7,  8,  9,  21, 22, 23, 28, 30, 34,
                                       35, 36, 51, 52, 53, 54, 60, 61, 62, 63, 68, 69, 70, 75, 76, 77};

constexpr std::pair<std::int64_t, const char*> solid_cells[] = {{11, "a voxel"},
                                                                {12, "a hexahedron"},
                                                                {13, "a wedge"},
                                                                {14, "a pyramid"},
                                                                {24, "a quadratic tetrahedron"},
                                                                {25, "a quadratic hexahedron"},
                                                                {42, "a polyhedron"},
                                                                {71, "a Lagrange tetrahedron"}};

std::string cell_name(std::int64_t type) {
  const std::string number = "cell type " + std::to_string(type);
  for (const auto& [solid, name] : solid_cells)
    if (solid == type) return std::string(name) + " (" + number + ")";
  return number;
}

template <class Number>
constexpr const char* type_name = nullptr;
template <>
constexpr const char* type_name<float> = "Float32";
template <>
constexpr const char* type_name<double> = "Float64";
template <>
constexpr const char* type_name<std::int32_t> = "Int32";
template <>
constexpr const char* type_name<std::int64_t> = "Int64";
template <>
constexpr const char* type_name<std::uint8_t> = "UInt8";

class VtuReader {
 public:
  explicit VtuReader(const std::string& path) : path_(path), bytes_(read_bytes(path, "a mesh in VTK's XML format (.vtu)")) {}

  TetMesh read() {
    parse_xml();
    const xml_node file = read_head();
    const xml_node grid = child(file, "UnstructuredGrid"), piece = child(grid, "Piece");
    if (const xml_node second = piece.next_sibling("Piece")) fail(second, "a second piece", "a mesh in one piece");
    constexpr std::int64_t most = std::numeric_limits<std::int32_t>::max();
    const std::size_t points = whole(piece, "NumberOfPoints", most), cells = whole(piece, "NumberOfCells", most);
    TetMesh mesh;
    read_points(child(child(piece, "Points"), "DataArray"), points, mesh);
    read_cells(child(piece, "Cells"), cells, mesh);
    return mesh;
  }

 private:
  const std::string& path_;
  const std::string bytes_;
  pugi::xml_document document_;
  std::string_view appended_;  // behind its '_'
  bool appended_base64_ = false;
  VtuCoding coding_;

  std::int64_t line_at(std::size_t offset) const {
    return 1 + std::count(bytes_.begin(), bytes_.begin() + static_cast<std::ptrdiff_t>(std::min(offset, bytes_.size())), '\n');
  }
  [[noreturn]] void fail(const xml_node& node, const std::string& found, const std::string& expected) const {
    fail_at(path_, line_at(static_cast<std::size_t>(node.offset_debug())), found, expected);
  }

  xml_node child(const xml_node& node, const char* name) const {
    const xml_node found = node.child(name);
    if (!found) fail(node, "no <" + std::string(name) + "> in <" + node.name() + ">", "one");
    return found;
  }
  std::string attribute(const xml_node& node, const char* name) const {
    const pugi::xml_attribute found = node.attribute(name);
    if (!found) fail(node, "<" + std::string(node.name()) + "> without " + name, "one");
    return found.value();
  }
  std::size_t whole(const xml_node& node, const char* name, std::int64_t most) const {
    const std::string text = attribute(node, name);
    std::int64_t number = 0;
    if (!parse(std::string_view(text), number) || number < 0 || number > most)
      fail(node, std::string(name) + " " + quote(text), "a whole number from 0 to " + std::to_string(most));
    return static_cast<std::size_t>(number);
  }

  // Raw appended data are no XML: the document ends at their tag.
  void parse_xml() {
    std::string text = bytes_;
    if (const std::size_t tag = bytes_.find("<AppendedData"); tag != std::string::npos) {
      const std::size_t end = bytes_.find('>', tag), sign = bytes_.find_first_not_of(blanks, end + 1);
      if (end == std::string::npos || sign == std::string::npos || bytes_[sign] != '_')
        fail_at(path_, line_at(tag), "<AppendedData> without data", "'_' and the data");
      appended_ = std::string_view(bytes_).substr(sign + 1);
      text = bytes_.substr(0, end) + "></AppendedData></VTKFile>";
    }
    const pugi::xml_parse_result result =
        document_.load_buffer(text.data(), text.size(), pugi::parse_minimal, pugi::encoding_utf8);
    if (!result)
      fail_at(path_, line_at(static_cast<std::size_t>(result.offset)), "bad XML (" + std::string(result.description()) + ")",
              "a mesh in VTK's XML format (.vtu)");
  }

  xml_node read_head() {
    const xml_node file = document_.child("VTKFile");
    if (!file) fail(document_.first_child(), "<" + std::string(document_.first_child().name()) + ">", "<VTKFile>");
    expect(file, "type", {"UnstructuredGrid"});
    expect(file, "byte_order", {"LittleEndian"});
    if (file.attribute("header_type")) coding_.head_bytes = expect(file, "header_type", {"UInt32", "UInt64"}) == "UInt32" ? 4 : 8;
    if (file.attribute("compressor")) coding_.zlib = expect(file, "compressor", {"vtkZLibDataCompressor"}) != "";
    if (const xml_node data = file.child("AppendedData")) {
      appended_base64_ = expect(data, "encoding", {"raw", "base64"}) == "base64";
      if (appended_base64_) appended_ = appended_.substr(0, appended_.find('<'));
    }
    return file;
  }

  // The attribute's value, one of these.
  std::string expect(const xml_node& node, const char* name, const std::vector<std::string>& values) const {
    const std::string value = attribute(node, name);
    if (std::find(values.begin(), values.end(), value) == values.end())
      fail(node, std::string(name) + " " + quote(value), one_of(values));
    return value;
  }

  void read_points(const xml_node& array, std::size_t count, TetMesh& mesh) const {
    expect(array, "NumberOfComponents", {"3"});
    const std::vector<double> x = read_array<double, float, double>(array, 3 * count);
    for (std::size_t i = 0; i < count; ++i) {
      mesh.nodes.emplace_back(x[3 * i], x[3 * i + 1], x[3 * i + 2]);
      if (!mesh.nodes[i].allFinite())
        fail(array, "point " + std::to_string(i) + " at a place that isn't finite", "finite coordinates");
    }
  }

  void read_cells(const xml_node& cells, std::size_t count, TetMesh& mesh) const {
    const xml_node connectivity = array_named(cells, "connectivity"), offsets = array_named(cells, "offsets"),
                   types = array_named(cells, "types");
    const auto ends = read_array<std::int64_t, std::int32_t, std::int64_t>(offsets, count);
    for (std::size_t c = 0; c < count; ++c)
      if (ends[c] < (c > 0 ? ends[c - 1] : 0) || ends[c] > most_corners)
        fail(offsets, "offset " + std::to_string(ends[c]) + of_cell(c), "ascending ones");
    const auto kinds = read_array<std::int64_t, std::uint8_t>(types, count);
    const std::size_t length = count > 0 ? static_cast<std::size_t>(ends.back()) : 0;
    const auto nodes = read_array<std::int64_t, std::int32_t, std::int64_t>(connectivity, length);
    for (std::size_t c = 0; c < count; ++c) {
      const std::int64_t kind = kinds[c], begin = c > 0 ? ends[c - 1] : 0;
      if (std::find(std::begin(flat_cells), std::end(flat_cells), kind) != std::end(flat_cells)) continue;
      if (kind != tetrahedron) fail(types, cell_name(kind) + of_cell(c), "tetrahedra of 4 points (cell type 10)");
      if (ends[c] - begin != 4)
        fail(offsets, "a tetrahedron of " + std::to_string(ends[c] - begin) + " points" + of_cell(c), "4");
      add_tet(connectivity, nodes.data() + begin, c, mesh);
    }
    if (mesh.tets.empty()) fail(types, "no tetrahedron", "cells of type 10 (tetrahedra of 4 points)");
  }
  static std::string of_cell(std::size_t cell) { return " (cell " + std::to_string(cell) + ")"; }

  void add_tet(const xml_node& connectivity, const std::int64_t* nodes, std::size_t cell, TetMesh& mesh) const {
    mesh.tets.emplace_back();
    for (std::size_t k = 0; k < 4; ++k) {
      if (nodes[k] < 0 || nodes[k] >= std::ssize(mesh.nodes))
        fail(connectivity, "point " + std::to_string(nodes[k]) + of_cell(cell),
             "points in [0, " + std::to_string(mesh.nodes.size()) + ")");
      mesh.tets.back()[k] = static_cast<std::int32_t>(nodes[k]);
    }
  }

  xml_node array_named(const xml_node& cells, const char* name) const {
    const xml_node array = cells.find_child_by_attribute("DataArray", "Name", name);
    if (!array) fail(cells, "no array '" + std::string(name) + "' in <Cells>", "connectivity, offsets and types");
    return array;
  }

  // Reads an array that must have so many numbers, stored in the file as one of the types `Stored`.
  template <class Number, class... Stored>
  std::vector<Number> read_array(const xml_node& array, std::size_t count) const {
    const std::string type = expect(array, "type", {type_name<Stored>...});
    std::vector<Number> numbers;
    ((type == type_name<Stored> ? read_stored<Number, Stored>(array, count, numbers) : void()), ...);
    return numbers;
  }

  template <class Number, class Stored>
  void read_stored(const xml_node& array, std::size_t count, std::vector<Number>& numbers) const {
    const std::string format = expect(array, "format", {"ascii", "binary", "appended"});
    if (format == "ascii") return read_text<Number, Stored>(array, count, numbers);
    const std::string bytes = binary_data(array, format == "appended", count * sizeof(Stored));
    numbers.resize(count);
    for (std::size_t i = 0; i < count; ++i) {
      Stored stored;
      std::memcpy(&stored, bytes.data() + i * sizeof stored, sizeof stored);
      numbers[i] = static_cast<Number>(stored);
    }
  }

  template <class Number, class Stored>
  void read_text(const xml_node& array, std::size_t count, std::vector<Number>& numbers) const {
    const std::string_view text = array.child_value();
    const auto start = static_cast<std::size_t>(array.first_child().offset_debug());
    for (std::size_t at = 0; (at = text.find_first_not_of(blanks, at)) != std::string_view::npos;) {
      const std::size_t end = std::min(text.find_first_of(blanks, at), text.size());
      Stored stored{};
      if (!parse(text.substr(at, end - at), stored))
        fail_at(path_, line_at(start + at), quote(text.substr(at, end - at)),
                std::string("a number of type ") + type_name<Stored>);
      numbers.push_back(static_cast<Number>(stored));
      at = end;
    }
    if (numbers.size() != count)
      fail(array, std::to_string(numbers.size()) + " numbers" + of_array(array), std::to_string(count));
  }

  std::string binary_data(const xml_node& array, bool appended, std::size_t size) const {
    std::string_view data = array.child_value();
    if (appended) {
      const std::size_t offset = whole(array, "offset", std::numeric_limits<std::int64_t>::max());
      if (offset > appended_.size())
        fail(array, "offset " + std::to_string(offset) + of_array(array), "one within the appended data");
      data = appended_.substr(offset);
    }
    try {
      return vtu_bytes(data, !appended || appended_base64_, coding_, size);
    } catch (const VtuFault& fault) {
      fail(array, fault.found + of_array(array), fault.expected);
    }
  }
  static std::string of_array(const xml_node& array) {
    return " in array '" + std::string(array.attribute("Name").value()) + "'";
  }
};

}  // namespace

TetMesh read_vtu(const std::string& path) { return VtuReader(path).read(); }

}  // namespace unibody
