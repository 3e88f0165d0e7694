// Surfaces of other programs' formats: the same tetrahedron in each, where the file's own tree places it.
#include "meshes/surface_file.hpp"

#include <algorithm>

#include "scene/scene_text.hpp"
#include "world/shape_library.hpp"

namespace unibody::surface_file_test {
namespace {

// Edges of 1, 2 and 0.5 m along the axes.
const std::vector<Vec3> corners{{0, 0, 0}, {1, 0, 0}, {0, 2, 0}, {0, 0, 0.5}};
constexpr int faces[4][3] = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};

std::string ply(const std::string& form) {
  std::string text =
      "ply\nformat " + form +
      " 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\nelement face 4\nproperty list "
      "uchar int vertex_indices\nend_header\n";
  const auto put = [&](auto number) {
    std::string bytes(reinterpret_cast<const char*>(&number), sizeof number);
    if (form == "binary_big_endian") std::ranges::reverse(bytes);
    text += form == "ascii" ? std::to_string(number) + " " : bytes;
  };
  for (const Vec3& x : corners)
    for (int k = 0; k < 3; ++k) put(static_cast<float>(x[k]));
  for (const auto& face : faces) {
    text += form == "ascii" ? "3 " : "\3";
    for (const int node : face) put(node);
  }
  return text;
}

// The same numbers in base64, as a file that one node moves by (0, 0, 3).
std::string gltf() {
  return R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
"nodes": [{"mesh": 0, "translation": [0, 0, 3]}],
"meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
"buffers": [{"byteLength": 72, "uri": "data:application/octet-stream;base64,)"
         R"(AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAAEAAAAAAAAAAAAAAAAAAAAA/AAACAAEAAAABAAMAAAADAAIAAQACAAMA"}],
"bufferViews": [{"buffer": 0, "byteOffset": 0, "byteLength": 48}, {"buffer": 0, "byteOffset": 48, "byteLength": 24}],
"accessors": [{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [0, 0, 0], "max": [1, 2, 0.5]},
{"bufferView": 1, "componentType": 5123, "count": 12, "type": "SCALAR"}]})";
}

// In millimetres, with z up, under a node that moves it by (0, 0, 3000).
std::string dae() {
  std::string places, indices;
  for (const Vec3& x : corners)
    for (int k = 0; k < 3; ++k) places += std::to_string(1000 * x[k]) + " ";
  for (const auto& face : faces)
    for (const int node : face) indices += std::to_string(node) + " ";
  return R"(<?xml version="1.0" encoding="utf-8"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit meter="0.001" name="millimeter"/><up_axis>Z_UP</up_axis></asset>
<library_geometries><geometry id="g"><mesh><source id="p"><float_array id="a" count="12">)" +
         places + R"(</float_array><technique_common>
<accessor source="#a" count="4" stride="3"><param name="X" type="float"/><param name="Y" type="float"/><param name="Z" type="float"/>
</accessor></technique_common></source><vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<triangles count="4"><input semantic="VERTEX" source="#v" offset="0"/><p>)" +
         indices + R"(</p></triangles></mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="s"><node id="n"><translate>0 0 3000</translate><instance_geometry url="#g"/></node>
</visual_scene></library_visual_scenes><scene><instance_visual_scene url="#s"/></scene></COLLADA>)";
}

// Whether each triangle is one of the tetrahedron's, moved, with its corners in the same order.
void expect_tetrahedron(const TriangleMesh& mesh, const Vec3& by, const std::string& what) {
  ASSERT_EQ(mesh.nodes.size(), 4U) << what;
  ASSERT_EQ(mesh.triangles.size(), 4U) << what;
  for (const auto& face : faces) {
    const auto is_this = [&](const std::array<std::int32_t, 3>& t) {
      for (std::size_t first = 0; first < 3; ++first) {
        bool same = true;
        for (std::size_t k = 0; k < 3; ++k)
          same &= (mesh.nodes[static_cast<std::size_t>(t[(first + k) % 3])] - corners[static_cast<std::size_t>(face[k])] - by)
                      .norm() < 1e-6;
        if (same) return true;
      }
      return false;
    };
    EXPECT_EQ(std::ranges::count_if(mesh.triangles, is_this), 1) << what;
  }
}

bool is_left_out() {
  const TextFile file(gltf(), ".gltf");
  try {
    read_surface(file.path());
  } catch (const InputError& error) {
    return std::string(error.what()).find("built without assimp") != std::string::npos;
  }
  return false;
}

}  // namespace

TEST(SurfaceFile, EveryFormatHasTheSameTriangles) {
  std::vector<std::tuple<std::string, std::string, double>> files{
      {".ply", ply("ascii"), 0}, {".PLY", ply("binary_little_endian"), 0}, {".ply", ply("binary_big_endian"), 0}};
  if (!is_left_out()) files.insert(files.end(), {{".gltf", gltf(), 3}, {".dae", dae(), 3}});
  for (const auto& [ending, text, height] : files) {
    const TextFile file(text, ending);
    expect_tetrahedron(read_surface(file.path()), Vec3(0, 0, height), ending);
  }
}

TEST(SurfaceFile, IsAShapeOfAScene) {
  if (is_left_out()) GTEST_SKIP() << "built without assimp";
  const TextFile file(gltf(), ".gltf");
  const std::string name = file.path().substr(file.path().rfind('/') + 1);
  const Scene scene = scene_from("bodies: [{shape: {hull: {mesh: " + name + "}}, density: 600}]\n");
  EXPECT_NEAR(scene.body(0).properties.mass, 600.0 / 6, 1e-4);
}

namespace {

std::string fault_in(const std::string& text, const std::string& ending, bool soup = false) {
  const TextFile file(text, ending);
  try {
    read_surface(file.path(), soup);
  } catch (const InputError& error) {
    std::string message = error.what();
    EXPECT_EQ(message.find(file.path()), 0U) << message;
    return message.substr(file.path().size());
  }
  return "";
}

std::string changed(const std::string& from, const std::string& to, const std::string& form = "ascii") {
  std::string text = ply(form);
  const std::size_t at = text.rfind(from);
  return at == std::string::npos ? "" : text.replace(at, from.size(), to);
}

}  // namespace

TEST(SurfaceFile, FaultsOfPlyFilesNameWhereTheyAre) {
  EXPECT_EQ(fault_in(changed("3 1 2 3", "3 1 2 2"), ".ply"), ": found a node twice in face 4, expected different nodes");
  EXPECT_EQ(fault_in(changed("3 1 2 3", "3 1 2 2"), ".ply", true), "");
  EXPECT_EQ(fault_in(changed("3 1 2 3", "3 1 2 4"), ".ply"),
            ": found node 4.000000 in face 4, expected a node that is there, from 0");
  EXPECT_EQ(fault_in(changed("3 1 2 3", "2 1 2"), ".ply"), ": found 2 nodes in face 4, expected three or more");
  EXPECT_EQ(fault_in(changed("0.500000", "nan"), ".ply"), ": found no finite place in vertex 4, expected finite numbers (m)");
  EXPECT_EQ(fault_in(changed("0.500000", "x"), ".ply"), ": found 'x' in vertex 4, expected a number");
  EXPECT_EQ(fault_in(changed("3 1 2 3", ""), ".ply"), ": found the end of the file in face 4, expected a number");
  EXPECT_EQ(fault_in(changed("element face 4", "element face many"), ".ply"),
            ":7: found 'many', expected a whole number from 0 to 2147483647");
  EXPECT_EQ(fault_in(changed("property float z", "property half z"), ".ply"),
            ":6: found 'half', expected char, uchar, short, ushort, int, uint, float or double");
  EXPECT_EQ(fault_in(changed("property float z", "property float w"), ".ply"),
            ":9: found no z of the element vertex, expected one");
  EXPECT_EQ(fault_in(changed("property float z", "property"), ".ply"),
            ":6: found 'property' with 0 words, expected a line of a PLY header");
  EXPECT_EQ(fault_in(changed("ascii", "utf8"), ".ply"),
            ":2: found 'utf8', expected ascii, binary_little_endian or binary_big_endian");
  EXPECT_EQ(fault_in("ply\nformat ascii 1.0\n", ".ply"), ":3: found the end of the file, expected end_header");
  EXPECT_EQ(fault_in("solid\n", ".ply"), ":1: found 'solid', expected ply");
  std::string cut = ply("binary_big_endian");
  cut.resize(cut.size() - 1);
  EXPECT_EQ(fault_in(cut, ".ply"), ": found the end of the file in face 4, expected a number");
}

TEST(SurfaceFile, FaultsThatAssimpFindsNameTheFile) {
  if (is_left_out()) GTEST_SKIP() << "built without assimp";
  EXPECT_NE(fault_in("{\"asset\": ", ".gltf").find("found what assimp refuses ("), std::string::npos);
  EXPECT_NE(fault_in("no xml", ".dae").find("found what assimp refuses ("), std::string::npos);
  std::string twice = dae();
  twice.replace(twice.find("1 2 3 </p>"), 10, "1 2 2 </p>");
  EXPECT_EQ(fault_in(twice, ".dae"), ": found a corner twice in face 4, expected different corners");
  EXPECT_EQ(fault_in(twice, ".dae", true), "");
}

}  // namespace unibody::surface_file_test
