// The reader of OBJ files: what it takes, and the message of everything that it refuses.
#include "meshes/obj.hpp"

#include "scene/scene_text.hpp"

namespace unibody::obj_test {
namespace {

using Triangle = std::array<std::int32_t, 3>;

TriangleMesh mesh_from(const std::string& text) { return read_obj(TextFile(text).path()); }

const std::string square = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

TEST(ReadObj, EveryFormOfAFaceAndEveryStatementThatIsSkipped) {
  const TriangleMesh mesh = mesh_from(
      "# a square\r\nmtllib a#b.mtl\no square\ng one two\n\n  v 0 0 0 # corner\nv\t1e0 +0 -0\nv 1 1 0 1\nv 0 1 .5 0.1 0.2 0.3\n"
      "vn 0 0 1\nvt 0 0\nvp 1 1\ns off\nusemtl cloth\nl 1 2\nf 1 2 3\nf 1/1 3/1 4/1\nf 1//1 2//1 3//1\nf 1/1/1 \\\r\n 2/1/1 "
      "3/1/1\n"
      "f -4 -3 -2\n  f 4 3 1");
  ASSERT_EQ(mesh.nodes.size(), 4u);
  EXPECT_EQ(mesh.nodes[1], Vec3(1, 0, 0));
  EXPECT_EQ(mesh.nodes[3], Vec3(0, 1, 0.5));
  const Triangle a{0, 1, 2}, b{0, 2, 3}, c{3, 2, 0};
  EXPECT_EQ(mesh.triangles, (std::vector<Triangle>{a, b, a, a, a, c}));
}

TEST(ReadObj, ConvexFacesAreFannedFromTheirFirstCorner) {
  EXPECT_EQ(mesh_from(square + "f 2 3 4 1\n").triangles, (std::vector<Triangle>{{1, 2, 3}, {1, 3, 0}}));
  // a pentagon with a straight corner, before its nodes, in a tilted plane
  const TriangleMesh mesh = mesh_from("f 1 2 3 4 5\nv 0 0 0\nv 1 0 1\nv 2 0 2\nv 2 1 2\nv 0 1 0\n");
  EXPECT_EQ(mesh.triangles, (std::vector<Triangle>{{0, 1, 2}, {0, 2, 3}, {0, 3, 4}}));
}

TEST(ReadObj, NumbersComeBackWithTheirBits) {
  const double x = 0.1 + 0.2, y = -1.0 / 3, z = 5e-324;
  char text[200];
  std::snprintf(text, sizeof text, "v %.17g %.17g %.17g\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", x, y, z);
  EXPECT_EQ(mesh_from(text).nodes[0], Vec3(x, y, z));
}

std::string obj_fault(const std::string& text) {
  const TextFile file(text);
  try {
    read_obj(file.path());
  } catch (const InputError& error) {
    std::string message = error.what();
    if (message.rfind(file.path(), 0) == 0) message.replace(0, file.path().size(), "FILE");
    return message;
  }
  return "";
}

struct BadMesh {
  const char* name;
  std::string text;
  std::string message;
};
void PrintTo(const BadMesh& bad, std::ostream* out) { *out << bad.name; }

class ReadObjRefuses : public testing::TestWithParam<BadMesh> {};

TEST_P(ReadObjRefuses, WithThisMessage) { EXPECT_EQ(obj_fault(GetParam().text), GetParam().message); }

const std::string corner_expected =
    ", expected a node of the face (a, a/b, a//c or a/b/c with whole numbers, from 1 or negative)";
const std::string node_expected = ", expected the three coordinates of a node, 'v x y z' (m)";

const std::vector<BadMesh> bad_meshes{
    {"empty", "", "FILE: found an empty file, expected a mesh in Wavefront OBJ"},
    {"only_comments", "# nothing\n", "FILE: found no face, expected at least one, 'f node node node'"},
    {"no_face", square, "FILE: found no face, expected at least one, 'f node node node'"},
    {"unknown_statement", square + "curv 1 2\n",
     "FILE:5: found 'curv', expected v, f, vn, vt, vp, l, o, g, s, usemtl, mtllib or a comment (#)"},
    {"binary", "\x7f\x45LF\x02\x01",
     "FILE:1: found '?ELF?\?', expected v, f, vn, vt, vp, l, o, g, s, usemtl, mtllib or a comment (#)"},
    {"two_coordinates", "v 0 0\n", "FILE:1: found 2 numbers" + node_expected},
    {"five_coordinates", "\nv 0 0 0 0 0\n", "FILE:2: found 5 numbers" + node_expected},
    {"no_coordinates", "v\n", "FILE:1: found 0 numbers" + node_expected},
    {"word", "v 0 zero 0\n", "FILE:1: found 'zero', expected a finite number"},
    {"number_and_rest", "v 0 1.5m 0\n", "FILE:1: found '1.5m', expected a finite number"},
    {"decimal_comma", "v 0,5 1 0\n", "FILE:1: found '0,5', expected a finite number"},
    {"nan", "v 0 nan 0\n", "FILE:1: found 'nan', expected a finite number"},
    {"inf", "v 0 -inf 0\n", "FILE:1: found '-inf', expected a finite number"},
    {"too_large", "v 0 1e999 0\n", "FILE:1: found '1e999', expected a finite number"},
    {"bad_colour", "v 0 0 0 1 1 red\n", "FILE:1: found 'red', expected a finite number"},
    {"face_of_two", square + "f 1 2\n", "FILE:5: found a face of 2 nodes, expected at least 3"},
    {"face_of_none", square + "f\n", "FILE:5: found a face of 0 nodes, expected at least 3"},
    {"node_zero", square + "f 0 1 2\n", "FILE:5: found '0'" + corner_expected},
    {"fraction", square + "f 1.5 2 3\n", "FILE:5: found '1.5'" + corner_expected},
    {"empty_node", square + "f /1 2 3\n", "FILE:5: found '/1'" + corner_expected},
    {"slash_at_the_end", square + "f 1/ 2 3\n", "FILE:5: found '1/'" + corner_expected},
    {"two_slashes_at_the_end", square + "f 1/1/ 2 3\n", "FILE:5: found '1/1/'" + corner_expected},
    {"four_parts", square + "f 1/1/1/1 2 3\n", "FILE:5: found '1/1/1/1'" + corner_expected},
    {"texture_a_word", square + "f 1/x 2 3\n", "FILE:5: found '1/x'" + corner_expected},
    {"beyond_the_nodes", square + "f 1 2 5\n", "FILE:5: found node 5 of 4 nodes, expected a node that is there"},
    {"far_beyond_the_nodes", square + "f 1 2 4294967297\n",
     "FILE:5: found node 4294967297 of 4 nodes, expected a node that is there"},
    {"back_beyond_the_nodes", square + "f -1 -2 -5\n", "FILE:5: found node -5 after 4 nodes, expected a node that is there"},
    {"back_before_the_nodes", "v 0 0 0\nf -1 -2 -3\n" + square,
     "FILE:2: found node -2 after 1 node, expected a node that is there"},
    {"node_twice", square + "f 1 2 2\n", "FILE:5: found node 2 twice in a face, expected different nodes"},
    {"node_twice_counted_both_ways", square + "f 1 2 -4\n", "FILE:5: found node 1 twice in a face, expected different nodes"},
    {"dart", "v 0 0 0\nv 2 -1 0\nv 0.5 0 0\nv 2 1 0\nf 1 2 3 4\n",
     "FILE:5: found a face that isn't convex, expected triangles or convex faces"},
    {"bow_tie", square + "f 1 2 4 3\n", "FILE:5: found a face that isn't convex, expected triangles or convex faces"},
    {"pentagram", "v 0 1 0\nv -.95 .31 0\nv -.59 -.81 0\nv .59 -.81 0\nv .95 .31 0\nf 1 3 5 2 4\n",
     "FILE:6: found a face that isn't convex, expected triangles or convex faces"},
    {"line_of_a_long_statement", square + "f 1 \\\n 2 \\\n 2\n",
     "FILE:5: found node 2 twice in a face, expected different nodes"},
    {"line_after_a_long_statement", square + "f 1 \\\n 2 \\\n 3\nf 1 2 x\n", "FILE:8: found 'x'" + corner_expected},
};

INSTANTIATE_TEST_SUITE_P(Obj, ReadObjRefuses, testing::ValuesIn(bad_meshes), [](const auto& bad) { return bad.param.name; });

TEST(ReadObj, MissingFileAndFolder) {
  for (const std::string path : {"/nonexistent/mesh.obj", "/tmp"}) try {
      read_obj(path);
      ADD_FAILURE() << path;
    } catch (const InputError& error) {
      EXPECT_EQ(std::string(error.what()).rfind(path + ": found no readable file (", 0), 0u) << error.what();
      EXPECT_NE(std::string(error.what()).find("), expected a mesh in Wavefront OBJ"), std::string::npos) << error.what();
    }
}

}  // namespace
}  // namespace unibody::obj_test
