#include "meshes/obj.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>

#include "meshes/corners.hpp"
#include "meshes/mesh_file.hpp"

namespace unibody {

namespace {

constexpr std::array<std::string_view, 9> skipped{"vn", "vt", "vp", "l", "o", "g", "s", "usemtl", "mtllib"};

struct Polygon {
  std::int64_t line;
  std::vector<std::int64_t> nodes;  // from 0
};

// The words of a statement up to a comment.
std::vector<std::string_view> words_of(std::string_view statement) {
  constexpr std::string_view blanks = " \t\r\v\f";
  statement = statement.substr(0, statement.find('#'));
  std::vector<std::string_view> words;
  for (std::size_t at = 0; (at = statement.find_first_not_of(blanks, at)) != std::string_view::npos;) {
    const std::size_t end = std::min(statement.find_first_of(blanks, at), statement.size());
    words.push_back(statement.substr(at, end - at));
    at = end;
  }
  return words;
}

class Reader {
 public:
  Reader(const std::string& path, bool soup) : path_(path), soup_(soup) {}

  TriangleMesh read() {
    std::istringstream file(read_bytes(path_, "a mesh in Wavefront OBJ"));
    std::string text, rest;
    while (std::getline(file, text)) {
      ++line_;
      const std::int64_t first = line_;
      while (ends_in_backslash(text) && std::getline(file, rest)) ++line_, text += rest;
      statement(text, first);
    }
    line_ = 0;
    if (polygons_.empty()) fail("no face", "at least one, 'f node node node'");
    for (const Polygon& polygon : polygons_) add_triangles(polygon);
    return std::move(mesh_);
  }

 private:
  const std::string& path_;
  bool soup_;
  std::int64_t line_ = 0;  // 0: the fault has no line
  TriangleMesh mesh_;
  std::vector<Polygon> polygons_;

  [[noreturn]] void fail(const std::string& found, const std::string& expected) const { fail_at(path_, line_, found, expected); }

  // A statement goes on in the next line; the backslash is taken off.
  static bool ends_in_backslash(std::string& text) {
    if (!text.empty() && text.back() == '\r') text.pop_back();
    if (text.empty() || text.back() != '\\') return false;
    text.back() = ' ';
    return true;
  }

  void statement(std::string_view text, std::int64_t first) {
    const auto words = words_of(text);
    if (words.empty()) return;
    const std::int64_t last = line_;
    line_ = first;
    if (words[0] == "v") {
      read_node(words);
    } else if (words[0] == "f") {
      read_face(words);
    } else if (std::find(skipped.begin(), skipped.end(), words[0]) == skipped.end()) {
      fail(quote(words[0]), "v, f, vn, vt, vp, l, o, g, s, usemtl, mtllib or a comment (#)");
    }
    line_ = last;
  }

  void read_node(const std::vector<std::string_view>& words) {
    double numbers[7] = {};
    const std::size_t count = words.size() - 1;  // x y z, x y z weight, x y z red green blue, or all seven
    if (count != 3 && count != 4 && count != 6 && count != 7)
      fail(std::to_string(count) + (count == 1 ? " number" : " numbers"), "the three coordinates of a node, 'v x y z' (m)");
    for (std::size_t i = 0; i < count; ++i)
      if (!parse(words[i + 1], numbers[i]) || !std::isfinite(numbers[i])) fail(quote(words[i + 1]), "a finite number");
    if (mesh_.nodes.size() == std::numeric_limits<std::int32_t>::max()) fail("more than 2^31 - 1 nodes", "fewer");
    mesh_.nodes.emplace_back(numbers[0], numbers[1], numbers[2]);
  }

  void read_face(const std::vector<std::string_view>& words) {
    if (words.size() < 4)
      fail("a face of " + std::to_string(words.size() - 1) + (words.size() == 2 ? " node" : " nodes"), "at least 3");
    Polygon polygon{line_, {}};
    for (std::size_t i = 1; i < words.size(); ++i) polygon.nodes.push_back(corner(words[i]));
    const bool kept = soup_ && polygon.nodes.size() == 3;
    for (std::size_t i = 1; i < polygon.nodes.size() && !kept; ++i)
      if (std::find(polygon.nodes.begin(), polygon.nodes.begin() + static_cast<std::ptrdiff_t>(i), polygon.nodes[i]) !=
          polygon.nodes.begin() + static_cast<std::ptrdiff_t>(i))
        fail("node " + std::to_string(polygon.nodes[i] + 1) + " twice in a face", "different nodes");
    polygons_.push_back(std::move(polygon));
  }

  // The node of "a", "a/b", "a//c" or "a/b/c"; b and c must be whole numbers, and are not looked up.
  std::int64_t corner(std::string_view word) const {
    std::array<std::string_view, 3> parts;
    std::size_t count = 0;
    for (std::string_view rest = word;; ++count) {
      const std::size_t slash = rest.find('/');
      if (count == 3) fail_corner(word);
      parts[count] = rest.substr(0, slash);
      if (slash == std::string_view::npos) break;
      rest.remove_prefix(slash + 1);
    }
    std::int64_t node = 0, other = 0;
    const bool good = parse(parts[0], node) && node != 0 &&
                      (count < 1 || parse(parts[1], other) || (count == 2 && parts[1].empty())) &&
                      (count < 2 || parse(parts[2], other));
    if (!good) fail_corner(word);
    const auto nodes = static_cast<std::int64_t>(mesh_.nodes.size());
    if (node < -nodes) fail("node " + std::string(parts[0]) + " after " + nodes_text(), "a node that is there");
    return node > 0 ? node - 1 : nodes + node;
  }
  [[noreturn]] void fail_corner(std::string_view word) const {
    fail(quote(word), "a node of the face (a, a/b, a//c or a/b/c with whole numbers, from 1 or negative)");
  }
  std::string nodes_text() const { return std::to_string(mesh_.nodes.size()) + (mesh_.nodes.size() == 1 ? " node" : " nodes"); }

  // Done when all nodes are known: a face may stand before its nodes.
  void add_triangles(const Polygon& polygon) {
    line_ = polygon.line;
    const auto nodes = static_cast<std::int64_t>(mesh_.nodes.size());
    for (const std::int64_t node : polygon.nodes)
      if (node >= nodes) fail("node " + std::to_string(node + 1) + " of " + nodes_text(), "a node that is there");
    std::vector<Vec3> places;
    for (const std::int64_t node : polygon.nodes) places.push_back(mesh_.nodes[static_cast<std::size_t>(node)]);
    if (places.size() > 3 && !is_convex(places)) fail("a face that isn't convex", "triangles or convex faces");
    for (std::size_t i = 2; i < polygon.nodes.size(); ++i)
      mesh_.triangles.push_back({static_cast<std::int32_t>(polygon.nodes[0]), static_cast<std::int32_t>(polygon.nodes[i - 1]),
                                 static_cast<std::int32_t>(polygon.nodes[i])});
  }
};

}  // namespace

TriangleMesh read_obj(const std::string& path, bool soup) { return Reader(path, soup).read(); }

}  // namespace unibody
