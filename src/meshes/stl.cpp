// Written by hand: of what Debian 12 has, assimp (12 MB with what it needs) and admesh read in single precision, take a file that
// is cut off for a shorter one or end with a message that names no place, and admesh writes to stderr by itself.
#include "meshes/stl.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>

#include "meshes/corners.hpp"
#include "meshes/mesh_file.hpp"

namespace unibody {

namespace {

static_assert(std::endian::native == std::endian::little, "binary STL is little-endian");

constexpr std::size_t header = 84, record = 50;  // bytes
const std::string a_mesh = "a mesh in STL";

TriangleMesh read_binary(const std::string& path, const std::string& bytes, std::size_t count, bool soup) {
  CornerMesh found(soup);
  for (std::size_t t = 0; t < count; ++t) {
    float numbers[12];  // the normal, then three corners
    std::memcpy(numbers, bytes.data() + header + record * t, sizeof numbers);
    std::array<Vec3, 3> corners;
    const std::string where = " in triangle " + std::to_string(t + 1);
    for (std::size_t k = 0; k < 9; ++k) {
      const float x = numbers[3 + k];
      if (!std::isfinite(x)) fail_at(path, 0, (std::isnan(x) ? "nan" : "infinity") + where, "a finite number (m)");
      corners[k / 3][static_cast<Eigen::Index>(k % 3)] = x;
    }
    if (!found.add(corners)) fail_at(path, 0, "a corner twice" + where, "three different corners");
  }
  return std::move(found.mesh);
}

class AsciiReader {
 public:
  AsciiReader(const std::string& path, const std::string& text, bool soup) : path_(path), text_(text), welded_(soup) {}

  TriangleMesh read() {
    while (next()) {
      check("solid");
      skip_line();
      while (need("facet or endsolid") != "endsolid") facet();
      skip_line();
    }
    return std::move(welded_.mesh);
  }

 private:
  const std::string& path_;
  const std::string& text_;
  std::size_t at_ = 0;
  std::int64_t line_ = 1;
  std::string_view word_;
  CornerMesh welded_;

  // The next word, whatever line it stands on; false at the end.
  bool next() {
    constexpr std::string_view blanks = " \t\r\v\f\n";
    for (; at_ < text_.size() && blanks.find(text_[at_]) != std::string_view::npos; ++at_) line_ += text_[at_] == '\n';
    const std::size_t end = std::min(text_.find_first_of(blanks, at_), text_.size());
    word_ = std::string_view(text_).substr(at_, end - at_);
    at_ = end;
    return !word_.empty();
  }
  std::string_view need(const std::string& expected) {
    if (!next()) fail_at(path_, line_, "the end of the file", expected);
    return word_;
  }
  void skip_line() { at_ = std::min(text_.find('\n', at_), text_.size()); }

  void check(const std::string& expected) {
    if (word_ != expected) fail_at(path_, line_, quote(word_), expected);
  }
  void take(const std::string& expected) { need(expected), check(expected); }
  double number() {
    double x = 0;
    if (!parse(need("a number (m)"), x) || !std::isfinite(x)) fail_at(path_, line_, quote(word_), "a finite number (m)");
    return x;
  }

  void facet() {
    if (word_ != "facet") fail_at(path_, line_, quote(word_), "facet or endsolid");
    const std::int64_t first = line_;
    take("normal");
    for (int k = 0; k < 3; ++k) need("a number");  // of some writers nan
    take("outer"), take("loop");
    std::array<Vec3, 3> corners;
    for (Vec3& x : corners) {
      take("vertex");
      for (Eigen::Index k = 0; k < 3; ++k) x[k] = number();
    }
    take("endloop"), take("endfacet");
    if (!welded_.add(corners)) fail_at(path_, first, "a corner twice in a facet", "three different corners");
  }
};

}  // namespace

TriangleMesh read_stl(const std::string& path, bool soup) {
  const std::string bytes = read_bytes(path, a_mesh);
  std::uint32_t count = 0;
  const bool has_count = bytes.size() >= header;
  if (has_count) std::memcpy(&count, bytes.data() + header - sizeof count, sizeof count);
  const bool is_binary = has_count && bytes.size() == header + record * count;
  const std::size_t start = bytes.find_first_not_of(" \t\r\n");
  const bool is_text = start != std::string::npos && bytes.compare(start, 5, "solid") == 0;
  if (!is_binary && !is_text) {
    if (!has_count) fail_at(path, 0, std::to_string(bytes.size()) + " bytes", a_mesh + ", 84 or more, or 'solid'");
    fail_at(path, 0, std::to_string(bytes.size()) + " bytes with a count of " + std::to_string(count) + " triangles",
            std::to_string(header + record * count) + " bytes (84, and 50 a triangle), or 'solid'");
  }
  if (is_binary && count > std::numeric_limits<std::int32_t>::max() / 3)
    fail_at(path, 0, std::to_string(count) + " triangles", "fewer than 2^31 corners");
  TriangleMesh mesh = is_binary ? read_binary(path, bytes, count, soup) : AsciiReader(path, bytes, soup).read();
  if (mesh.triangles.empty()) fail_at(path, 0, "no triangle", "at least one");
  return mesh;
}

}  // namespace unibody
