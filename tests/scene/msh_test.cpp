// The reader of Gmsh's meshes: every variant written here byte by byte, files of Gmsh itself, and the message of every fault.
#include "meshes/msh.hpp"

#include <algorithm>
#include <cstring>
#include <limits>

#include "scene/scene_text.hpp"

namespace unibody::msh_test {
namespace {

using Tet = std::array<std::int32_t, 4>;

template <class Number>
std::string bytes(Number number) {
  std::string text(sizeof number, '\0');
  std::memcpy(text.data(), &number, sizeof number);
  return text;
}
template <class Number>
std::string bytes(std::initializer_list<Number> numbers) {
  std::string text;
  for (const Number number : numbers) text += bytes(number);
  return text;
}
std::string ints(std::initializer_list<std::int32_t> numbers) { return bytes(numbers); }
std::string longs(std::initializer_list<std::int64_t> numbers) { return bytes(numbers); }
std::string reals(std::initializer_list<double> numbers) { return bytes(numbers); }

// One mesh in the four variants: nodes 7, 2, 40, 9, 3 of two tets 12 and 5, with a point, a line and a triangle of 6 nodes.
const std::string text_2 =
    "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n1\n3 1 \"a $Nodes\"\n$EndPhysicalNames\n"
    "$Nodes\n6\n7 0 0 0\n2 1 0 0\n40 0 1 0\n9 0 0 1\n3 .5 .5 -1e0\n8 +9 9 9\n$EndNodes\n"
    "$Elements\n5\n12 4 2 1 1 2 7 40 3\n1 15 2 0 1 7\n20 1 3 0 1 5 7 2\n5 4 0 7 2 40 9\n6 9 2 1 1 7 2 40 7 2 40\n$EndElements\n";
const std::string binary_2 =
    "$MeshFormat\n2.2 1 8\n" + ints({1}) + "\n$EndMeshFormat\n$Nodes\n6\n" + ints({7}) + reals({0, 0, 0}) + ints({2}) +
    reals({1, 0, 0}) + ints({40}) + reals({0, 1, 0}) + ints({9}) + reals({0, 0, 1}) + ints({3}) + reals({.5, .5, -1}) +
    ints({8}) + reals({9, 9, 9}) + "\n$EndNodes\n$Elements\n5\n" + ints({4, 2, 2, 12, 1, 1, 2, 7, 40, 3, 5, 1, 1, 7, 2, 40, 9}) +
    ints({15, 1, 1, 1, 0, 7}) + ints({1, 1, 0, 20, 7, 2, 9, 1, 0, 6, 7, 2, 40, 7, 2, 40}) + "\n$EndElements\n";
const std::string text_4 =
    "$MeshFormat\n4.1 0 8\n$EndMeshFormat\r\n$Entities\n$Nodes\n1 2\n$EndEntities\n"
    "$Nodes\n4 6 2 40\n2 1 1 2\n7\n2\n0 0 0 .1 .2\n1 0 0 .3 .4\n3 1 0 3\n40\n9\n3\n0 1 0\n0 0 1\n.5 .5 -1\n"
    "1 7 1 0\n0 4 1 1\n8\n9 9 9\n$EndNodes\n"
    "$Elements\n4 5 1 20\n3 1 4 2\n12 2 7 40 3 \n5 7 2 40 9 \n0 1 15 1\n1 7\n1 1 1 1\n20 7 2\n2 1 9 1\n6 7 2 40 7 2 40\n"
    "$EndElements\n$Periodic\n0\n$EndPeriodic";
const std::string binary_4 = "$MeshFormat\n4.1 1 8\n" + ints({1}) + "\n$EndMeshFormat\n$Entities\n" + longs({1, 2}) +
                             "\n$EndEntities\n$Nodes\n" + longs({3, 6, 2, 40}) + ints({2, 1, 1}) + longs({2, 7, 2}) +
                             reals({0, 0, 0, .1, .2, 1, 0, 0, .3, .4}) + ints({3, 1, 0}) + longs({3, 40, 9, 3}) +
                             reals({0, 1, 0, 0, 0, 1, .5, .5, -1}) + ints({0, 4, 1}) + longs({1, 8}) + reals({9, 9, 9}) +
                             "\n$EndNodes\n$Elements\n" + longs({4, 5, 1, 20}) + ints({3, 1, 4}) +
                             longs({2, 12, 2, 7, 40, 3, 5, 7, 2, 40, 9}) + ints({0, 1, 15}) + longs({1, 1, 7}) + ints({1, 1, 1}) +
                             longs({1, 20, 7, 2}) + ints({2, 1, 9}) + longs({1, 6, 7, 2, 40, 7, 2, 40}) + "\n$EndElements\n";

TEST(ReadMsh, EveryVariantGivesNodesAndTetsByAscendingTag) {
  for (const std::string& text : {text_2, binary_2, text_4, binary_4}) {
    SCOPED_TRACE(text.substr(12, 8));
    const TetMesh mesh = read_msh(TextFile(text).path());
    const std::vector<Vec3> nodes{{1, 0, 0}, {.5, .5, -1}, {0, 0, 0}, {9, 9, 9}, {0, 0, 1}, {0, 1, 0}};  // 2, 3, 7, 8, 9, 40
    EXPECT_EQ(mesh.nodes, nodes);
    EXPECT_EQ(mesh.tets, (std::vector<Tet>{{2, 0, 5, 4}, {0, 2, 5, 1}}));  // inverted ones are left as they are
  }
}

TEST(ReadMsh, NumbersComeBackWithTheirBits) {
  const double x = 0.1 + 0.2, y = -1.0 / 3, z = 5e-324;
  char node[200];
  std::snprintf(node, sizeof node, "1 %.17g %.17g %.17g\n", x, y, z);
  const std::string rest = "2 1 0 0\n3 0 1 0\n4 0 0 1\n$EndNodes\n$Elements\n1\n1 4 0 1 2 3 4\n$EndElements\n";
  const TetMesh mesh = read_msh(TextFile("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n4\n" + (node + rest)).path());
  EXPECT_EQ(mesh.nodes[0], Vec3(x, y, z));
}

TEST(ReadMsh, FilesOfGmshInEveryVariantHoldTheSameMesh) {
  const std::string folder = std::string(UNIBODY_SOURCE_DIR) + "/tests/data/";
  const TetMesh first = read_msh(folder + "gmsh_22.msh");
  EXPECT_EQ(first.nodes.size(), 13u);
  ASSERT_EQ(first.tets.size(), 16u);
  EXPECT_EQ(first.tets[0], (Tet{11, 9, 10, 12}));
  EXPECT_EQ(first.nodes[3], Vec3(0, 0, 1));
  for (const char* name : {"gmsh_22_binary.msh", "gmsh_41.msh", "gmsh_41_binary.msh"}) {
    SCOPED_TRACE(name);
    const TetMesh mesh = read_msh(folder + name);
    EXPECT_EQ(mesh.tets, first.tets);
    ASSERT_EQ(mesh.nodes.size(), first.nodes.size());
    for (std::size_t n = 0; n < mesh.nodes.size(); ++n) EXPECT_LT((mesh.nodes[n] - first.nodes[n]).norm(), 1e-15);
  }
}

std::string msh_fault(const std::string& text) {
  const TextFile file(text);
  try {
    read_msh(file.path());
  } catch (const InputError& error) {
    std::string message = error.what();
    if (message.rfind(file.path(), 0) == 0) message.replace(0, file.path().size(), "FILE");
    return message;
  }
  return "";
}

// `text` with the only `old` replaced.
std::string with(std::string text, const std::string& old, const std::string& replacement) {
  const std::size_t at = text.find(old);
  EXPECT_NE(at, std::string::npos) << old;
  EXPECT_EQ(text.find(old, at + 1), std::string::npos) << old;
  return text.replace(at, old.size(), replacement);
}

struct BadMsh {
  const char* name;
  std::string text;
  std::string where;    // stands once in the text, at the fault
  std::string message;  // with @ for the line or the byte of `where`
};
void PrintTo(const BadMsh& bad, std::ostream* out) { *out << bad.name; }

class ReadMshRefuses : public testing::TestWithParam<BadMsh> {};

TEST_P(ReadMshRefuses, WithThisMessage) {
  const auto& [name, text, where, expected] = GetParam();
  std::string message = expected;
  if (!where.empty()) {
    const std::size_t byte = text.find(where), sign = message.find('@');
    ASSERT_NE(byte, std::string::npos);
    ASSERT_EQ(text.find(where, byte + 1), std::string::npos);
    const auto line = 1 + std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(byte), '\n');
    message.replace(sign, 1, std::to_string(message[sign - 1] == ':' ? line : static_cast<std::ptrdiff_t>(byte)));
  }
  EXPECT_EQ(msh_fault(text), message);
}

const std::string format_4 = "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n";
const std::string only_tets = ", expected tetrahedra of 4 nodes (element type 4)";
const double nan = std::numeric_limits<double>::quiet_NaN();

const std::vector<BadMsh> bad_meshes{
    {"empty", "", "", "FILE: found an empty file, expected a mesh in Gmsh's format"},
    {"blank", "\n \n", "", "FILE: found no nodes, expected a section $Nodes"},
    {"another_format", "\nsolid cube\n", "solid", "FILE:@: found 'solid cube', expected a mesh in Gmsh's format, '$MeshFormat'"},
    {"version_1", "$NOD\n0\n$ENDNOD\n", "$NOD", "FILE:@: found a section without end, expected '$EndNOD'"},
    {"no_format", "$Nodes\n0\n$EndNodes\n", "$Nodes",
     "FILE:@: found '$Nodes', expected $MeshFormat first (versions 2.2 and 4.1)"},
    {"version_40", with(text_4, "4.1 0 8", "4 0 8"), "4 0 8",
     "FILE:@: found version '4', expected version 2.2 or 4.1 of Gmsh's format"},
    {"version_20", with(text_2, "2.2 0 8", "2 0 8"), "2 0 8",
     "FILE:@: found version '2', expected version 2.2 or 4.1 of Gmsh's format"},
    {"file_type", with(text_2, "2.2 0 8", "2.2 2 8"), "2.2 2 8", "FILE:@: found file type 2, expected 0 (text) or 1 (binary)"},
    {"data_size", with(text_2, "2.2 0 8", "2.2 0 4"), "2.2 0 4", "FILE:@: found numbers of 4 bytes, expected 8"},
    {"short_format", with(text_2, "2.2 0 8", "2.2 0"), "2.2 0", "FILE:@: found the end of the line, expected numbers of 8 bytes"},
    {"long_format", with(text_2, "2.2 0 8", "2.2 0 8 x"), "0 8 x", "FILE:@: found 'x', expected the end of the line"},
    {"big_endian", with(binary_2, ints({1}) + "\n$End", ints({0x01000000}) + "\n$End"), ints({0x01000000}) + "\n",
     "FILE: found a big-endian file at byte @, expected a little-endian one, or text"},
    {"no_one", with(binary_2, ints({1}) + "\n$End", ints({77}) + "\n$End"), ints({77}),
     "FILE: found 77 at byte @, expected the number 1 in binary"},
    {"no_nodes", format_4, "", "FILE: found no nodes, expected a section $Nodes"},
    {"no_elements", format_4 + "$Nodes\n0 0 0 0\n$EndNodes\n", "",
     "FILE: found no tetrahedron, expected elements of type 4 (tetrahedra of 4 nodes)"},
    {"no_tets", with(text_4, "$Elements\n4 5 1 20\n3 1 4 2\n12 2 7 40 3 \n5 7 2 40 9 \n", "$Elements\n3 3 1 20\n"), "",
     "FILE: found no tetrahedron, expected elements of type 4 (tetrahedra of 4 nodes)"},
    {"nodes_twice", text_4 + "\n$Nodes\n0 0 0 0\n$EndNodes\n", "$Nodes\n0 0",
     "FILE:@: found $Nodes twice, expected one such section"},
    {"no_section", with(text_2, "$Elements\n5\n", "Elements\n5\n"), "Elements\n5",
     "FILE:@: found 'Elements', expected a section, '$...'"},
    {"section_without_end", with(text_2, "$EndPhysicalNames", "$EndPhysical"), "$PhysicalNames",
     "FILE:@: found a section without end, expected '$EndPhysicalNames'"},
    {"more_nodes", with(text_2, "$Nodes\n6", "$Nodes\n5"), "8 +9 9 9", "FILE:@: found '8 +9 9 9', expected '$EndNodes'"},
    {"fewer_nodes", with(text_2, "$Nodes\n6", "$Nodes\n7"), "$EndNodes",
     "FILE:@: found '$EndNodes', expected a node's tag, from 1"},
    {"negative_count", with(text_2, "$Nodes\n6", "$Nodes\n-1"), "-1\n7", "FILE:@: found -1, expected the number of nodes"},
    {"count_too_long", with(text_2, "$Nodes\n6", "$Nodes\n99999999999999999999"), "99999999999999999999",
     "FILE:@: found '99999999999999999999', expected the number of nodes"},
    {"node_zero", with(text_2, "7 0 0 0", "0 0 0 0"), "0 0 0 0", "FILE:@: found tag 0, expected a node's tag, from 1"},
    {"two_coordinates", with(text_2, "2 1 0 0", "2 1 0"), "2 1 0\n",
     "FILE:@: found the end of the line, expected a node's coordinate (m)"},
    {"four_coordinates", with(text_2, "2 1 0 0", "2 1 0 0 5"), "0 0 5", "FILE:@: found '5', expected the end of the line"},
    {"word", with(text_2, "2 1 0 0", "2 1 zero 0"), "zero", "FILE:@: found 'zero', expected a node's coordinate (m)"},
    {"nan", with(text_2, "2 1 0 0", "2 1 nan 0"), "nan", "FILE:@: found nan, expected a node's coordinate (m)"},
    {"inf", with(text_2, "2 1 0 0", "2 1 -inf 0"), "-inf", "FILE:@: found an infinite number, expected a node's coordinate (m)"},
    {"binary_nan", with(binary_2, reals({1, 0, 0}), reals({1, nan, 0})), reals({nan}),
     "FILE: found nan at byte @, expected a node's coordinate (m)"},
    {"node_twice", with(text_2, "\n9 0 0 1", "\n40 0 0 1"), "40 0 0 1",
     "FILE:@: found node 40 a second time, expected each tag once"},
    {"element_twice", with(text_2, "5 4 0 7", "12 4 0 7"), "12 4 0 7",
     "FILE:@: found element 12 a second time, expected each tag once"},
    {"missing_node", with(text_2, "5 4 0 7 2 40 9", "5 4 0 7 2 41 9"), "2 41 9",
     "FILE:@: found node 41 in element 5, expected a node of $Nodes"},
    {"missing_node_4", with(text_4, "5 7 2 40 9", "5 7 2 40 1"), "2 40 1",
     "FILE:@: found node 1 in element 5, expected a node of $Nodes"},
    {"missing_node_binary", with(binary_4, longs({5, 7, 2, 40, 9}), longs({5, 7, 2, 40, 41})), longs({5, 7, 2, 40, 41}),
     "FILE: found node 41 in element 5 at byte @, expected a node of $Nodes"},
    {"three_nodes", with(text_2, "5 4 0 7 2 40 9", "5 4 0 7 2 40"), "4 0 7 2 40",
     "FILE:@: found the end of the line, expected the tag of an element's node, from 1"},
    {"hexahedron", with(text_2, "5 4 0 7 2 40 9", "5 5 0 7 2 40 9 1 2 3 4"), "5 5 0",
     "FILE:@: found a hexahedron (element type 5)" + only_tets},
    {"prism", with(text_4, "2 1 9 1\n", "3 1 6 1\n"), "3 1 6 1", "FILE:@: found a prism (element type 6)" + only_tets},
    {"pyramid", with(binary_4, ints({2, 1, 9}), ints({3, 77, 7})), ints({7}) + longs({1, 6}),
     "FILE: found a pyramid (element type 7) at byte @" + only_tets},
    {"second_order", with(text_4, "3 1 4 2", "3 1 11 2"), "1 11 2",
     "FILE:@: found a tetrahedron of 10 nodes (element type 11)" + only_tets},
    {"unknown_type", with(text_2, "5 4 0 7 2 40 9", "5 142 0 7"), "142", "FILE:@: found element type 142" + only_tets},
    {"negative_type", with(text_2, "5 4 0 7 2 40 9", "5 -4 0 7"), "-4", "FILE:@: found element type -4" + only_tets},
    {"longer_block_than_announced", with(binary_2, "$Elements\n5\n", "$Elements\n1\n"), ints({2, 12}),
     "FILE: found 2 elements at byte @, expected 1, as the section's head says"},
    {"elements_of_blocks", with(text_4, "4 5 1 20", "4 6 1 20"), "7 2 40 7 2 40",
     "FILE:@: found 5 elements, expected 6, as the section's head says"},
    {"nodes_of_blocks", with(text_4, "4 6 2 40", "4 7 2 40"), "9 9 9",
     "FILE:@: found 6 nodes, expected 7, as the section's head says"},
    {"dimension", with(text_4, "3 1 0 3", "4 1 0 3"), "4 1 0 3", "FILE:@: found 4, expected an entity's dimension, 0 to 3"},
    {"parametric", with(text_4, "3 1 0 3", "3 1 2 3"), "3 1 2 3", "FILE:@: found 2, expected 0 or 1 (parametric)"},
    {"parameter_missing", with(text_4, "0 0 0 .1 .2", "0 0 0 .1"), "0 0 0 .1",
     "FILE:@: found the end of the line, expected a node's parameter"},
    {"text_cut_off", text_2.substr(0, text_2.find("$EndElements")), "",
     "FILE:23: found the end of the file, expected '$EndElements'"},
    {"huge_block", with(binary_4, longs({3, 40, 9, 3}), longs({std::int64_t{1} << 60, 40, 9, 3})), reals({0, 1, 0, 0}),
     "FILE: found tag 0 at byte @, expected a node's tag, from 1"},
};

INSTANTIATE_TEST_SUITE_P(Msh, ReadMshRefuses, testing::ValuesIn(bad_meshes), [](const auto& bad) { return bad.param.name; });

TEST(ReadMsh, EveryCutOfABinaryFileIsRefused) {
  for (const std::string& text : {binary_2, binary_4})
    for (std::size_t size = 0; size + 1 < text.size(); ++size)
      EXPECT_EQ(msh_fault(text.substr(0, size)).rfind("FILE", 0), 0u) << size;
}

TEST(ReadMsh, MissingFileAndFolder) {
  for (const std::string path : {"/nonexistent/mesh.msh", "/tmp"}) try {
      read_msh(path);
      ADD_FAILURE() << path;
    } catch (const InputError& error) {
      EXPECT_EQ(std::string(error.what()).rfind(path + ": found no readable file (", 0), 0u) << error.what();
    }
}

}  // namespace
}  // namespace unibody::msh_test
