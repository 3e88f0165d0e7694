// The reader of STL files: both forms give the mesh that the same triangles in OBJ do, and every fault has its message.
#include "meshes/stl.hpp"

#include <cstring>
#include <limits>

#include "meshes/mesh_topology.hpp"
#include "scene/scene_text.hpp"
#include "world/shape_library.hpp"

namespace unibody::stl_test {
namespace {

using Corners = std::array<Vec3, 3>;

// The twelve triangles of a block off the origin; coordinates that single precision holds.
std::vector<Corners> block() {
  constexpr int faces[12][3] = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                                {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  std::vector<Corners> result;
  for (const auto& f : faces) {
    Corners c;
    for (std::size_t i = 0; i < 3; ++i) c[i] = Vec3(f[i] & 1 ? 1.25 : 1, f[i] & 2 ? 0.5 : 0, f[i] & 4 ? 0.75 : 0);
    result.push_back(c);
  }
  return result;
}

std::string ascii(const std::vector<Corners>& triangles, const std::string& name = "a block") {
  std::string text = "solid " + name + "\n";
  for (const Corners& t : triangles) {
    text += "  facet normal 0 0 0\n    outer loop\n";
    for (const Vec3& x : t) {
      char line[100];
      std::snprintf(line, sizeof line, "      vertex %.17g %.17g %.17g\n", x.x(), x.y(), x.z());
      text += line;
    }
    text += "    endloop\n  endfacet\n";
  }
  return text + "endsolid " + name + "\n";
}

std::string binary(const std::vector<Corners>& triangles, std::string head = "solid with a binary header") {
  head.resize(80, '\0');
  const auto count = static_cast<std::uint32_t>(triangles.size());
  head.append(reinterpret_cast<const char*>(&count), 4);
  for (const Corners& t : triangles) {
    float numbers[12] = {};
    for (std::size_t k = 0; k < 9; ++k) numbers[3 + k] = static_cast<float>(t[k / 3][static_cast<Eigen::Index>(k % 3)]);
    head.append(reinterpret_cast<const char*>(numbers), sizeof numbers).append(2, '\7');
  }
  return head;
}

TriangleMesh mesh_from(const std::string& bytes) { return read_stl(TextFile(bytes).path()); }

std::string stl_fault(const std::string& bytes) {
  const TextFile file(bytes);
  try {
    read_stl(file.path());
  } catch (const InputError& error) {
    return std::string(error.what()).replace(0, file.path().size(), "FILE");
  }
  return "";
}

TEST(ReadStl, BothFormsWeldTheirCorners) {
  for (const std::string& bytes : {ascii(block()), binary(block())}) {
    const TriangleMesh mesh = mesh_from(bytes);
    EXPECT_EQ(mesh.nodes.size(), 8u);
    ASSERT_EQ(mesh.triangles.size(), 12u);
    for (std::size_t t = 0; t < 12; ++t)
      for (std::size_t k = 0; k < 3; ++k)
        EXPECT_EQ(mesh.nodes[static_cast<std::size_t>(mesh.triangles[t][k])], block()[t][k]) << t;
    EXPECT_TRUE(mesh_topology(mesh, "block").boundary.empty());
    EXPECT_NO_THROW(check_mesh(mesh, "block"));
  }
}

TEST(ReadStl, NumbersOfAsciiAreDoubleAndZeroHasNoSign) {
  const double x = 0.1 + 0.2;
  const TriangleMesh mesh = mesh_from(ascii({{Vec3(x, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1)}}) + "\n" +
                                      ascii({{Vec3(x, -0.0, 0), Vec3(0, 0, 1), Vec3(1, 1, 1)}}, "another"));
  EXPECT_EQ(mesh.nodes.size(), 4u);  // two solids of one file have a corner in common
  EXPECT_EQ(mesh.nodes[0].x(), x);
  EXPECT_EQ(mesh.triangles[1], (std::array<std::int32_t, 3>{0, 2, 3}));
}

// A corner that another program has rounded otherwise: a crack, which is no closed surface.
TEST(ReadStl, CornersThatDifferInTheLastBitStayApart) {
  auto triangles = block();
  triangles[0][0].x() = std::nextafter(triangles[0][0].x(), 2);
  EXPECT_EQ(mesh_from(ascii(triangles)).nodes.size(), 9u);
}

TEST(ReadStl, EveryFaultHasItsPlace) {
  const std::string good = ascii(block()), bytes = binary(block());
  const auto with = [&](const std::string& what, const std::string& other) {
    std::string text = good;
    return text.replace(text.find(what), what.size(), other);
  };
  EXPECT_EQ(stl_fault(with("vertex 1 0 0\n", "vertex 1 0 x\n")), "FILE:4: found 'x', expected a finite number (m)");
  EXPECT_EQ(stl_fault(with("vertex 1 0 0\n", "vertex 1 0 inf\n")), "FILE:4: found 'inf', expected a finite number (m)");
  EXPECT_EQ(stl_fault(with("vertex 1 0 0\n", "vertex 1 0\n")), "FILE:5: found 'vertex', expected a finite number (m)");
  EXPECT_EQ(stl_fault(with("endloop", "vertex")), "FILE:7: found 'vertex', expected endloop");
  EXPECT_EQ(stl_fault(with("  facet", "  face")), "FILE:2: found 'face', expected facet or endsolid");
  EXPECT_EQ(stl_fault(good.substr(0, good.find("endsolid"))), "FILE:86: found the end of the file, expected facet or endsolid");
  EXPECT_EQ(stl_fault(with("vertex 1 0.5 0\n", "vertex 1 0 0\n")),
            "FILE:2: found a corner twice in a facet, expected three different corners");
  EXPECT_EQ(stl_fault("solid nothing\nendsolid\n"), "FILE: found no triangle, expected at least one");
  EXPECT_EQ(stl_fault(good + "and more\n"), "FILE:87: found 'and', expected solid");

  const std::string headed = binary(block(), "made by a program");
  EXPECT_EQ(stl_fault(headed.substr(0, headed.size() - 1)),
            "FILE: found 683 bytes with a count of 12 triangles, expected 684 bytes (84, and 50 a triangle), or 'solid'");
  EXPECT_EQ(stl_fault("v 0 0 0\n"), "FILE: found 8 bytes, expected a mesh in STL, 84 or more, or 'solid'");
  auto twice = block();
  twice[4][2] = twice[4][0];
  EXPECT_EQ(stl_fault(binary(twice)), "FILE: found a corner twice in triangle 5, expected three different corners");
  std::string infinite = bytes;
  const float no_number = std::numeric_limits<float>::quiet_NaN();
  std::memcpy(infinite.data() + 84 + 50 * 2 + 12, &no_number, sizeof no_number);
  EXPECT_EQ(stl_fault(infinite), "FILE: found nan in triangle 3, expected a finite number (m)");
  EXPECT_NE(stl_fault("").find("an empty file"), std::string::npos);
}

// A file with the name x.stl, that lives as long as the object.
class StlFile {
 public:
  explicit StlFile(const std::string& bytes) : path_(::testing::TempDir() + "scene_" + std::to_string(getpid()) + ".stl") {
    std::ofstream(path_, std::ios::binary) << bytes;
  }
  ~StlFile() { std::remove(path_.c_str()); }
  const std::string& path() const { return path_; }

 private:
  std::string path_;
};

// In scenes: a solid's mass from its STL, a hole refused, a cloth, a static mesh.
TEST(ReadStl, ShapesAndClothsTakeIt) {
  {
    const StlFile file(binary(block()));
    const Scene scene = scene_from("bodies:\n  - {shape: {compound: {mesh: " + file.path() + ", pieces: 2}}, density: 1000}\n" +
                                   "  - {shape: {hull: {mesh: " + file.path() + "}}, density: 1000}\n" +
                                   "  - {shape: {mesh: {file: " + file.path() + ", scale: 2}}, motion: fixed}\n");
    EXPECT_NEAR(scene.body(0).properties.mass, 1000 * 0.25 * 0.5 * 0.75, 1e-9);
    EXPECT_NEAR(scene.body(1).properties.mass, 1000 * 0.25 * 0.5 * 0.75, 1e-9);
    EXPECT_TRUE(shape_library().meshes[scene.body(2).properties.shape.data].is_solid);
    EXPECT_NEAR(scene.body(2).properties.shape.size.x(), 2.5, 1e-12);
  }
  auto open = block();
  open.pop_back();
  const StlFile file(ascii(open));
  EXPECT_NE(fault_of("bodies:\n  - {shape: {compound: {mesh: " + file.path() + "}}, density: 1000}\n").find("a mesh with a hole"),
            std::string::npos);
  EXPECT_EQ(scene_from("cloths:\n  - {mesh: " + file.path() + ", mass: 1, thickness: 0.01, links: {}}\n").body_count(), 8);
  auto flat = block();
  flat[0][1] = flat[0][0];
  const StlFile soup(binary(flat));  // terrain alone may hold what has no area
  const std::string static_mesh = "bodies:\n  - {shape: {mesh: {file: " + soup.path() + "}}}\n";
  const Scene terrain = scene_from(static_mesh);
  EXPECT_EQ(shape_library().meshes[terrain.body(0).properties.shape.data].triangles.size(), 11u);
  EXPECT_EQ(terrain.notes, std::vector<std::string>{soup.path() + ": left out 1 triangle without area"});
  EXPECT_NE(fault_of("cloths:\n  - {mesh: " + soup.path() + ", mass: 1, thickness: 0.01, links: {}}\n").find("a corner twice"),
            std::string::npos);
}

}  // namespace
}  // namespace unibody::stl_test
