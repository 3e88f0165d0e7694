#include "meshes/msh.hpp"

#include <algorithm>
#include <limits>
#include <tuple>

#include "meshes/mesh_file.hpp"
#include "meshes/msh_input.hpp"

namespace unibody {

namespace {

// Nodes of an element of lower dimension, by its type; 0: a volume element, or a type of no fixed number of nodes.
constexpr std::int32_t flat_nodes[] = {0,   2,  3,  4,  0,  0,  0,  0,  3,  6,  9,  0,  0,  0,  0,  1,  8,
                                       0,   0,  0,  9,  10, 12, 15, 15, 21, 4,  5,  6,  0,  0,  0,  0,  0,
                                       0,   0,  16, 25, 36, 12, 16, 20, 28, 36, 45, 55, 66, 49, 64, 81, 100,
                                       121, 18, 21, 24, 27, 30, 24, 28, 32, 36, 40, 7,  8,  9,  10, 11};

constexpr std::int64_t tetrahedron = 4;

constexpr std::pair<std::int64_t, const char*> solids[] = {{5, "a hexahedron"},
                                                           {6, "a prism"},
                                                           {7, "a pyramid"},
                                                           {11, "a tetrahedron of 10 nodes"},
                                                           {12, "a hexahedron"},
                                                           {13, "a prism"},
                                                           {14, "a pyramid"},
                                                           {17, "a hexahedron"},
                                                           {18, "a prism"},
                                                           {19, "a pyramid"},
                                                           {29, "a tetrahedron of 20 nodes"}};

std::string type_name(std::int64_t type) {
  const std::string number = "element type " + std::to_string(type);
  for (const auto& [solid, name] : solids)
    if (solid == type) return std::string(name) + " (" + number + ")";
  return number;
}

class MshReader {
 public:
  explicit MshReader(const std::string& path) : path_(path), in_(path) {}

  TetMesh read() {
    for (std::string_view line = in_.line(); !line.empty(); line = in_.line()) {
      if (line[0] != '$') in_.fail(quote(line), version_ == 0 ? "a mesh in Gmsh's format, '$MeshFormat'" : "a section, '$...'");
      section(std::string(line.substr(1)));
    }
    if (!has_nodes_) fail_at(path_, 0, "no nodes", "a section $Nodes");
    if (tets_.empty()) fail_at(path_, 0, "no tetrahedron", "elements of type 4 (tetrahedra of 4 nodes)");
    sort_by_tag(nodes_, "node");
    sort_by_tag(tets_, "element");
    return mesh();
  }

 private:
  template <class Content>
  struct Tagged {
    std::int64_t tag;
    Content content;
    std::size_t mark;
  };

  const std::string& path_;
  MshInput in_;
  int version_ = 0;    // 2 or 4
  int tag_bytes_ = 0;  // of tags and of counts
  bool has_nodes_ = false;
  std::vector<Tagged<Vec3>> nodes_;
  std::vector<Tagged<std::array<std::int64_t, 4>>> tets_;

  void section(const std::string& name) {
    if (name == "MeshFormat") {
      read_format();
    } else if (name != "Nodes" && name != "Elements") {
      return in_.skip_past("$End" + name);
    } else if (version_ == 0) {
      in_.fail("'$" + name + "'", "$MeshFormat first (versions 2.2 and 4.1)");
    } else if (name == "Nodes") {
      if (has_nodes_) in_.fail("$Nodes twice", "one such section");
      has_nodes_ = true;
      version_ == 2 ? read_nodes_2() : read_nodes_4();
    } else {
      version_ == 2 ? read_elements_2() : read_elements_4();
    }
    const std::string_view end = in_.line();
    if (end != "$End" + name) in_.fail(end.empty() ? "the end of the file" : quote(end), "'$End" + name + "'");
  }

  void read_format() {
    const std::string_view version = in_.word("a version");
    if (version != "2.2" && version != "4.1") in_.fail("version " + quote(version), "version 2.2 or 4.1 of Gmsh's format");
    version_ = version == "2.2" ? 2 : 4;
    tag_bytes_ = version_ == 2 ? 4 : 8;
    const std::int64_t binary = in_.text_whole("0 (text) or 1 (binary)");
    if (binary != 0 && binary != 1) in_.fail("file type " + std::to_string(binary), "0 (text) or 1 (binary)");
    const std::int64_t size = in_.text_whole("numbers of 8 bytes");
    if (size != 8) in_.fail("numbers of " + std::to_string(size) + " bytes", "8");
    in_.end_text_line();
    in_.binary = binary == 1;
    if (!in_.binary) return;
    const std::int64_t one = in_.whole(4, "the number 1 in binary");
    if (one == 0x01000000) in_.fail("a big-endian file", "a little-endian one, or text");
    if (one != 1) in_.fail(std::to_string(one), "the number 1 in binary");
  }

  std::int64_t tag(const char* what) {
    const std::int64_t tag = in_.whole(tag_bytes_, what);
    if (tag < 1) in_.fail("tag " + std::to_string(tag), what);
    return tag;
  }
  std::int64_t count(int bytes, const char* what) {
    const std::int64_t count = in_.whole(bytes, what);
    if (count < 0) in_.fail(std::to_string(count), what);
    return count;
  }
  // Reads a count in a section of version 2.2, which is text even in binary files.
  std::int64_t text_count(const char* what) {
    const std::int64_t count = in_.text_whole(what);
    if (count < 0) in_.fail(std::to_string(count), what);
    in_.end_text_line();
    return count;
  }
  void check_total(std::int64_t total, std::int64_t announced, const char* what) {
    if (total != announced)
      in_.fail(std::to_string(total) + " " + what, std::to_string(announced) + ", as the section's head says");
  }

  Vec3 place() {
    Vec3 x;
    for (double& coordinate : x) coordinate = in_.real("a node's coordinate (m)");
    return x;
  }

  void read_nodes_2() {
    for (std::int64_t left = text_count("the number of nodes"); left > 0; --left) {
      const std::int64_t node = tag("a node's tag, from 1");
      const std::size_t mark = in_.mark();
      nodes_.push_back({node, place(), mark});
      in_.end_line();
    }
  }

  void read_nodes_4() {
    const std::int64_t blocks = count(8, "the number of blocks"), nodes = count(8, "the number of nodes");
    in_.whole(8, "the least tag"), in_.whole(8, "the greatest tag");
    in_.end_line();
    for (std::int64_t block = 0; block < blocks; ++block) read_node_block();
    check_total(static_cast<std::int64_t>(nodes_.size()), nodes, "nodes");
  }

  void read_node_block() {
    const std::int64_t dimension = in_.whole(4, "an entity's dimension");
    if (dimension < 0 || dimension > 3) in_.fail(std::to_string(dimension), "an entity's dimension, 0 to 3");
    in_.whole(4, "an entity's tag");
    const std::int64_t parametric = in_.whole(4, "0 or 1 (parametric)");
    if (parametric != 0 && parametric != 1) in_.fail(std::to_string(parametric), "0 or 1 (parametric)");
    const std::int64_t size = count(8, "the number of nodes of a block");
    in_.end_line();
    const std::size_t first = nodes_.size();
    for (std::int64_t i = 0; i < size; ++i) {
      const std::int64_t node = tag("a node's tag, from 1");
      nodes_.push_back({node, Vec3::Zero(), in_.mark()});
      in_.end_line();
    }
    for (std::size_t i = first; i < nodes_.size(); ++i) {
      nodes_[i].content = place();
      for (std::int64_t k = 0; k < parametric * dimension; ++k) in_.real("a node's parameter");
      in_.end_line();
    }
  }

  void read_elements_2() {
    const std::int64_t elements = text_count("the number of elements");
    for (std::int64_t left = elements; left > 0;) {
      std::int64_t element = 0;
      std::size_t mark = 0;
      if (!in_.binary) element = tag("an element's tag, from 1"), mark = in_.mark();
      const std::int64_t type = element_type();
      const std::int64_t size = in_.binary ? count(4, "the number of elements of a block") : 1;
      const std::int64_t tags = count(4, "the number of an element's tags");
      if (size > left) check_total(elements - left + size, elements, "elements");
      for (std::int64_t i = 0; i < size; ++i, --left) {
        if (in_.binary) element = tag("an element's tag, from 1"), mark = in_.mark();
        for (std::int64_t k = 0; k < tags; ++k) in_.whole(4, "an element's physical, elementary or partition tag");
        read_element(type, element, mark);
      }
    }
  }

  void read_elements_4() {
    const std::int64_t blocks = count(8, "the number of blocks"), elements = count(8, "the number of elements");
    in_.whole(8, "the least tag"), in_.whole(8, "the greatest tag");
    in_.end_line();
    std::int64_t total = 0;
    for (std::int64_t block = 0; block < blocks; ++block) {
      in_.whole(4, "an entity's dimension"), in_.whole(4, "an entity's tag");
      const std::int64_t type = element_type();
      const std::int64_t size = count(8, "the number of elements of a block");
      in_.end_line();
      for (std::int64_t i = 0; i < size; ++i) {
        const std::int64_t element = tag("an element's tag, from 1");
        read_element(type, element, in_.mark());
      }
      total += size;
    }
    check_total(total, elements, "elements");
  }

  std::int64_t element_type() {
    const std::int64_t type = in_.whole(4, "an element's type");
    const bool flat = type >= 0 && type < std::ssize(flat_nodes) && flat_nodes[type] > 0;
    if (type != tetrahedron && !flat) in_.fail(type_name(type), "tetrahedra of 4 nodes (element type 4)");
    return type;
  }

  void read_element(std::int64_t type, std::int64_t element, std::size_t mark) {
    constexpr const char* what = "the tag of an element's node, from 1";
    if (type == tetrahedron) {
      std::array<std::int64_t, 4> nodes;
      for (std::int64_t& node : nodes) node = tag(what);
      tets_.push_back({element, nodes, mark});
    } else {
      for (std::int32_t k = 0; k < flat_nodes[type]; ++k) tag(what);
    }
    in_.end_line();
  }

  template <class List>
  void sort_by_tag(List& list, const std::string& what) const {
    if (list.size() > std::numeric_limits<std::int32_t>::max()) fail_at(path_, 0, "more than 2^31 - 1 " + what + "s", "fewer");
    std::sort(list.begin(), list.end(),
              [](const auto& a, const auto& b) { return std::tie(a.tag, a.mark) < std::tie(b.tag, b.mark); });
    const auto twice = std::adjacent_find(list.begin(), list.end(), [](const auto& a, const auto& b) { return a.tag == b.tag; });
    if (twice != list.end())
      in_.fail(what + " " + std::to_string(twice->tag) + " a second time", "each tag once", (twice + 1)->mark);
  }

  TetMesh mesh() const {
    TetMesh mesh;
    for (const auto& node : nodes_) mesh.nodes.push_back(node.content);
    for (const auto& tet : tets_) {
      mesh.tets.emplace_back();
      for (std::size_t k = 0; k < 4; ++k) {
        const auto at = std::lower_bound(nodes_.begin(), nodes_.end(), tet.content[k],
                                         [](const auto& node, std::int64_t tag) { return node.tag < tag; });
        if (at == nodes_.end() || at->tag != tet.content[k])
          in_.fail("node " + std::to_string(tet.content[k]) + " in element " + std::to_string(tet.tag), "a node of $Nodes",
                   tet.mark);
        mesh.tets.back()[k] = static_cast<std::int32_t>(at - nodes_.begin());
      }
    }
    return mesh;
  }
};

}  // namespace

TetMesh read_msh(const std::string& path) { return MshReader(path).read(); }

}  // namespace unibody
