// The reader of VTK's meshes: every coding written here byte by byte, files of VTK itself, and the message of every fault.
#include "meshes/vtu.hpp"

#include <zlib.h>

#include <algorithm>
#include <cstring>

#include "scene/scene_text.hpp"

namespace unibody::vtu_test {
namespace {

using Tet = std::array<std::int32_t, 4>;

const std::vector<double> places{0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, .5, .5, -1};
const std::vector<std::int64_t> corners{0, 1, 2, 3, 0, 1, 2, 4, 0, 2, 1, 4}, ends{4, 7, 8, 12}, kinds{10, 5, 1, 10};

// How a test writes its arrays; block 0: without compression.
struct Coding {
  std::string format;
  std::string encoding;
  std::size_t head_bytes = 4, block = 0;
  bool narrow = false;  // Float32 and Int32
};
void PrintTo(const Coding& c, std::ostream* out) {
  *out << c.format << c.encoding << "_head_" << c.head_bytes << "_block_" << c.block << (c.narrow ? "_narrow" : "");
}

template <class Stored, class Number>
std::string bytes_of(const std::vector<Number>& numbers) {
  std::string bytes;
  for (const Number number : numbers) {
    const auto stored = static_cast<Stored>(number);
    bytes.append(reinterpret_cast<const char*>(&stored), sizeof stored);
  }
  return bytes;
}

std::string head(const Coding& coding, const std::vector<std::uint64_t>& numbers) {
  return coding.head_bytes == 4 ? bytes_of<std::uint32_t>(numbers) : bytes_of<std::uint64_t>(numbers);
}

std::string base64(const std::string& bytes) {
  constexpr std::string_view alphabet = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string bits, text;
  for (const char c : bytes)
    for (int k = 7; k >= 0; --k) bits += (static_cast<unsigned char>(c) >> k & 1) ? '1' : '0';
  while (bits.size() % 6 != 0) bits += '0';
  for (std::size_t i = 0; i < bits.size(); i += 6) text += alphabet[std::stoul(bits.substr(i, 6), nullptr, 2)];
  while (text.size() % 4 != 0) text += '=';
  return text;
}

// Head and data as VTK writes them: in base64 as one text, but two where compressed.
std::string coded(const Coding& coding, const std::string& bytes) {
  const bool raw = coding.encoding == "raw";
  if (coding.block == 0) {
    const std::string all = head(coding, {bytes.size()}) + bytes;
    return raw ? all : base64(all);
  }
  std::vector<std::uint64_t> sizes{0, coding.block, bytes.size() % coding.block};
  std::string packed;
  for (std::size_t at = 0; at < bytes.size(); at += coding.block) {
    const std::string block = bytes.substr(at, coding.block);
    std::string to(compressBound(block.size()), '\0');
    uLongf length = to.size();
    compress(reinterpret_cast<Bytef*>(to.data()), &length, reinterpret_cast<const Bytef*>(block.data()), block.size());
    packed += to.substr(0, length);
    sizes.push_back(length), ++sizes[0];
  }
  return raw ? head(coding, sizes) + packed : base64(head(coding, sizes)) + base64(packed);
}

// A file of four cells: a tet, a triangle, a vertex, a tet.
std::string vtu(const Coding& coding) {
  std::string appended;
  const auto array = [&](const std::string& type, const std::string& attributes, const auto& numbers, const std::string& bytes) {
    std::string text = "<DataArray type=\"" + type + "\" " + attributes + " format=\"" + coding.format + "\"";
    if (coding.format == "appended") {
      text += " offset=\"" + std::to_string(appended.size()) + "\"/>\n";
      appended += coded(coding, bytes);
      return text;
    }
    text += ">\n";
    if (coding.format == "binary") text += "  " + coded(coding, bytes);
    if (coding.format == "ascii")
      for (const auto number : numbers) text += " " + std::to_string(number) + (number > 0 ? "\n" : "");
    return text + "\n</DataArray>\n";
  };
  const std::string whole = coding.narrow ? "Int32" : "Int64";
  const auto wide = [&](const auto& n) { return coding.narrow ? bytes_of<std::int32_t>(n) : bytes_of<std::int64_t>(n); };
  std::string text = std::string("<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" byte_order=\"LittleEndian\"") +
                     (coding.head_bytes == 8 ? " header_type=\"UInt64\"" : "") +
                     (coding.block > 0 ? " compressor=\"vtkZLibDataCompressor\"" : "") +
                     ">\n<UnstructuredGrid>\n<Piece NumberOfPoints=\"5\" NumberOfCells=\"4\">\n<PointData/>\n<Points>\n";
  text += array(coding.narrow ? "Float32" : "Float64", "NumberOfComponents=\"3\"", places,
                coding.narrow ? bytes_of<float>(places) : bytes_of<double>(places));
  text += "</Points>\n<Cells>\n";
  text += array(whole, "Name=\"connectivity\"", corners, wide(corners));
  text += array(whole, "Name=\"offsets\"", ends, wide(ends));
  text += array("UInt8", "Name=\"types\"", kinds, bytes_of<std::uint8_t>(kinds));
  text += "</Cells>\n</Piece>\n</UnstructuredGrid>\n";
  if (coding.format == "appended")
    text += "<AppendedData encoding=\"" + coding.encoding + "\">\n _" + appended + "\n</AppendedData>\n";
  return text + "</VTKFile>\n";
}

void expect_the_mesh(const TetMesh& mesh) {
  const std::vector<Vec3> nodes{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {.5, .5, -1}};
  EXPECT_EQ(mesh.nodes, nodes);
  EXPECT_EQ(mesh.tets, (std::vector<Tet>{{0, 1, 2, 3}, {0, 2, 1, 4}}));
}

TEST(ReadVtu, EveryCodingGivesTheSameMesh) {
  for (const bool narrow : {false, true})
    for (const std::size_t head_bytes : {4, 8}) {
      expect_the_mesh(read_vtu(TextFile(vtu({"ascii", "", head_bytes, 0, narrow})).path()));
      for (const std::size_t block : {0, 8, 64, 4096})  // many, some, one; with and without a part of a block at the end
        for (const Coding& coding : {Coding{"binary", "", head_bytes, block, narrow},
                                     {"appended", "raw", head_bytes, block, narrow},
                                     {"appended", "base64", head_bytes, block, narrow}}) {
          SCOPED_TRACE(testing::PrintToString(coding));
          expect_the_mesh(read_vtu(TextFile(vtu(coding)).path()));
        }
    }
}

TEST(ReadVtu, FilesOfVtkInEveryCodingHoldTheSameMesh) {
  for (const char* name : {"ascii", "binary_32", "binary_zlib_64", "appended_64", "appended_zlib_32", "appended_base64_32",
                           "appended_zlib_base64_64"}) {
    SCOPED_TRACE(name);
    expect_the_mesh(read_tet_mesh(std::string(UNIBODY_SOURCE_DIR) + "/tests/data/vtk_" + name + ".vtu", 0).mesh);
  }
}

std::string vtu_fault(const std::string& text) {
  const TextFile file(text);
  try {
    read_vtu(file.path());
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

struct BadVtu {
  const char* name;
  std::string text;
  std::string where;    // stands once in the text, in the line of the fault
  std::string message;  // with @ for that line
};
void PrintTo(const BadVtu& bad, std::ostream* out) { *out << bad.name; }

class ReadVtuRefuses : public testing::TestWithParam<BadVtu> {};

TEST_P(ReadVtuRefuses, WithThisMessage) {
  const auto& [name, text, where, expected] = GetParam();
  std::string message = expected;
  if (!where.empty()) {
    const std::size_t byte = text.find(where);
    ASSERT_NE(byte, std::string::npos);
    ASSERT_EQ(text.find(where, byte + 1), std::string::npos);
    const auto line = 1 + std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(byte), '\n');
    message.replace(message.find('@'), 1, std::to_string(line));
  }
  EXPECT_EQ(vtu_fault(text), message);
}

const std::string text = vtu({"ascii", ""}), raw = vtu({"appended", "raw", 8}), packed = vtu({"appended", "raw", 8, 64}),
                  inlined = vtu({"binary", ""});
const std::string format = "a mesh in VTK's XML format (.vtu)", only_tets = ", expected tetrahedra of 4 points (cell type 10)";
const std::string points = "NumberOfComponents", types = "\"types\"";

const std::vector<BadVtu> bad_meshes{
    {"empty", "", "", "FILE: found an empty file, expected " + format},
    {"no_xml", "\nsolid\n", "", "FILE:3: found bad XML (No document element found), expected " + format},
    {"bad_xml", with(text, "</Points>", "</Point>"), "</Point>",
     "FILE:@: found bad XML (Start-end tags mismatch), expected " + format},
    {"another_root", "<html>\n</html>\n", "<html>", "FILE:@: found <html>, expected <VTKFile>"},
    {"poly_data", with(text, "type=\"UnstructuredGrid\"", "type=\"PolyData\""), "<VTKFile",
     "FILE:@: found type 'PolyData', expected UnstructuredGrid"},
    {"big_endian", with(text, "LittleEndian", "BigEndian"), "<VTKFile",
     "FILE:@: found byte_order 'BigEndian', expected LittleEndian"},
    {"no_byte_order", with(text, "byte_order", "order"), "<VTKFile", "FILE:@: found <VTKFile> without byte_order, expected one"},
    {"header_type", with(raw, "UInt64", "UInt16"), "<VTKFile", "FILE:@: found header_type 'UInt16', expected UInt32 or UInt64"},
    {"compressor", with(packed, "vtkZLib", "vtkLZ4"), "<VTKFile",
     "FILE:@: found compressor 'vtkLZ4DataCompressor', expected vtkZLibDataCompressor"},
    {"no_piece", "<VTKFile type=\"UnstructuredGrid\" byte_order=\"LittleEndian\">\n<UnstructuredGrid/>\n</VTKFile>", "<Unstr",
     "FILE:@: found no <Piece> in <UnstructuredGrid>, expected one"},
    {"two_pieces", with(text, "</Piece>", "</Piece>\n<Piece/>"), "<Piece/>",
     "FILE:@: found a second piece, expected a mesh in one piece"},
    {"number_of_points", with(text, "NumberOfPoints=\"5\"", "NumberOfPoints=\"-5\""), "<Piece",
     "FILE:@: found NumberOfPoints '-5', expected a whole number from 0 to 2147483647"},
    {"components", with(text, "Components=\"3\"", "Components=\"2\""), points,
     "FILE:@: found NumberOfComponents '2', expected 3"},
    {"too_many_points", with(text, "NumberOfPoints=\"5\"", "NumberOfPoints=\"4\""), points,
     "FILE:@: found 15 numbers in array '', expected 12"},
    {"word", with(text, "-1.0", "-one"), "-one", "FILE:@: found '-one00000', expected a number of type Float64"},
    {"nan", with(text, "-1.0", "nan 0"), points, "FILE:@: found 16 numbers in array '', expected 15"},
    {"infinite", with(text, "-1.000000", "inf"), points,
     "FILE:@: found point 4 at a place that isn't finite, expected finite coordinates"},
    {"type_of_types", with(text, "UInt8", "Int8"), types, "FILE:@: found type 'Int8', expected UInt8"},
    {"type_of_points", with(text, "Float64", "Float16"), points, "FILE:@: found type 'Float16', expected Float32 or Float64"},
    {"format", with(text, "Name=\"types\" format=\"ascii\"", "Name=\"types\" format=\"hex\""), types,
     "FILE:@: found format 'hex', expected ascii, binary or appended"},
    {"too_large", with(text, " 10\n 5\n", " 300\n 5\n"), " 300", "FILE:@: found '300', expected a number of type UInt8"},
    {"no_offsets", with(text, "\"offsets\"", "\"ends\""), "<Cells>",
     "FILE:@: found no array 'offsets' in <Cells>, expected connectivity, offsets and types"},
    {"descending_offsets", with(text, " 7\n 8\n", " 7\n 6\n"), "\"offsets\"",
     "FILE:@: found offset 6 (cell 2), expected ascending ones"},
    {"huge_offset", with(text, " 8\n 12\n", " 8\n 2305843009213693956\n"), "\"offsets\"",
     "FILE:@: found offset 2305843009213693956 (cell 3), expected ascending ones"},
    {"fewer_corners", with(text, " 8\n 12\n", " 8\n 13\n"), "\"connectivity\"",
     "FILE:@: found 12 numbers in array 'connectivity', expected 13"},
    {"hexahedron", with(text, " 10\n 5\n", " 12\n 5\n"), types, "FILE:@: found a hexahedron (cell type 12) (cell 0)" + only_tets},
    {"second_order", with(text, " 1\n 10\n", " 1\n 24\n"), types,
     "FILE:@: found a quadratic tetrahedron (cell type 24) (cell 3)" + only_tets},
    {"unknown_cell", with(text, " 1\n 10\n", " 1\n 99\n"), types, "FILE:@: found cell type 99 (cell 3)" + only_tets},
    {"tet_of_three", with(text, " 10\n 5\n", " 5\n 10\n"), "\"offsets\"",
     "FILE:@: found a tetrahedron of 3 points (cell 1), expected 4"},
    {"no_tets", with(with(text, " 10\n 5\n", " 5\n 5\n"), " 1\n 10\n", " 1\n 5\n"), types,
     "FILE:@: found no tetrahedron, expected cells of type 10 (tetrahedra of 4 points)"},
    {"beyond_the_points", with(text, " 1\n 4\n\n", " 1\n 5\n\n"), "\"connectivity\"",
     "FILE:@: found point 5 (cell 3), expected points in [0, 5)"},
    {"negative_point", with(text, " 1\n 4\n\n", " 1\n -4\n\n"), "\"connectivity\"",
     "FILE:@: found point -4 (cell 3), expected points in [0, 5)"},
    {"encoding", with(raw, "encoding=\"raw\"", "encoding=\"hex\""), "<AppendedData",
     "FILE:@: found encoding 'hex', expected raw or base64"},
    {"no_appended_data", raw.substr(0, raw.find(" _")), "<AppendedData",
     "FILE:@: found <AppendedData> without data, expected '_' and the data"},
    {"offset_beyond", with(raw, "offset=\"0\"", "offset=\"9999\""), points,
     "FILE:@: found offset 9999 in array '', expected one within the appended data"},
    {"offset_elsewhere", with(raw, "offset=\"128\"", "offset=\"0\""), "\"connectivity\"",
     "FILE:@: found 120 bytes in array 'connectivity', expected 96 bytes"},
    {"cut_off", raw.substr(0, raw.find("</Appended") - 3), types,
     "FILE:@: found data that end too early in array 'types', expected as many as their head says"},
    {"base64", with(inlined, "BAAAAAoFAQo=", "BAAAAA*FAQo="), types, "FILE:@: found '*' in array 'types', expected base64"},
    {"base64_cut_off", with(inlined, "BAAAAAoFAQo=", "BAAAAAoF"), types,
     "FILE:@: found data that end too early in array 'types', expected as many as their head says"},
};

INSTANTIATE_TEST_SUITE_P(Vtu, ReadVtuRefuses, testing::ValuesIn(bad_meshes), [](const auto& bad) { return bad.param.name; });

TEST(ReadVtu, DamagedBlocksAreRefused) {
  std::string damaged = packed;
  damaged[damaged.find(" _") + 2 + 8 * 5 + 4] ^= 0x55;  // within the first block, behind a head of five numbers
  EXPECT_NE(vtu_fault(damaged).find("found a compressed block that is damaged in array '', expected zlib data of 64 bytes"),
            std::string::npos)
      << vtu_fault(damaged);
  std::string larger = packed;
  larger[larger.find(" _") + 2 + 8 + 1] = 1;  // blocks of 64 + 256 bytes
  EXPECT_NE(vtu_fault(larger).find("found blocks of a wrong size in array '', expected 120 bytes"), std::string::npos)
      << vtu_fault(larger);
}

TEST(ReadVtu, EveryCutOfAFileIsRefused) {
  for (const std::string& whole : {text, raw, packed, inlined, vtu({"appended", "base64", 4, 8})}) {
    const std::size_t end = whole.find("</AppendedData>");
    const std::size_t needed = (end == std::string::npos ? whole.size() : end) - 2;  // but for the line's end
    for (std::size_t size = 0; size < needed; ++size) EXPECT_EQ(vtu_fault(whole.substr(0, size)).rfind("FILE", 0), 0u) << size;
  }
}

TEST(ReadVtu, MissingFileAndFolder) {
  for (const std::string path : {"/nonexistent/mesh.vtu", "/tmp"}) try {
      read_vtu(path);
      ADD_FAILURE() << path;
    } catch (const InputError& error) {
      EXPECT_EQ(std::string(error.what()).rfind(path + ": found no readable file (", 0), 0u) << error.what();
    }
}

}  // namespace
}  // namespace unibody::vtu_test
