#include "meshes/vtu_data.hpp"

#include <zlib.h>

#include <bit>
#include <cstdint>
#include <cstring>
#include <vector>

namespace unibody {

static_assert(std::endian::native == std::endian::little, "binary numbers are taken as they stand");

namespace {

// The six bits of a base64 character; -1 for any other character.
int six_bits(char c) {
  constexpr std::string_view alphabet = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  const std::size_t place = alphabet.find(c);
  return place == std::string_view::npos ? -1 : static_cast<int>(place);
}

// The bytes that whole groups of four characters stand for. VTK codes the head of a compressed array on its own, so that
// padding may stand in the midst.
std::string decoded(std::string_view text, std::size_t size) {
  std::string bytes;
  std::uint32_t group = 0;
  int characters = 0, padding = 0;
  for (const char c : text) {
    if (bytes.size() >= size) break;
    if (c == ' ' || c == '\n' || c == '\t' || c == '\r') continue;
    const int bits = c == '=' && characters >= 2 ? 0 : six_bits(c);
    if (bits < 0 || (padding > 0 && c != '=')) throw VtuFault{std::string("'") + c + "'", "base64"};
    padding += c == '=';
    group = group << 6 | static_cast<std::uint32_t>(bits);
    if (++characters < 4) continue;
    for (int k = 0; k < 3 - padding; ++k) bytes.push_back(static_cast<char>(group >> (16 - 8 * k) & 0xff));
    group = 0, characters = 0, padding = 0;
  }
  return bytes;
}

class Array {
 public:
  Array(std::string_view data, bool base64, const VtuCoding& coding) : data_(data), base64_(base64), coding_(coding) {}

  std::string plain(std::size_t size) const {
    check_size(head(1)[0], size);
    return first(coding_.head_bytes + size).substr(coding_.head_bytes);
  }

  // The head: the number of blocks, the size of a block and of the last one (0: a whole one), and each one's size when
  // compressed.
  std::string inflated(std::size_t size) const {
    const std::uint64_t blocks = head(1)[0];
    if (blocks > data_.size()) fail_end();
    if (blocks == 0) return check_size(0, size), std::string();
    const std::size_t numbers = 3 + static_cast<std::size_t>(blocks);
    const std::vector<std::uint64_t> sizes = head(numbers);
    const std::uint64_t block = sizes[1], last = sizes[2] > 0 ? sizes[2] : block;
    if (last > block || (blocks > 1 && block > size / (blocks - 1))) throw VtuFault{"blocks of a wrong size", bytes_text(size)};
    check_size((blocks - 1) * block + last, size);
    std::size_t end = numbers * coding_.head_bytes;
    for (std::size_t b = 0; b < blocks; end += sizes[3 + b], ++b)
      if (sizes[3 + b] > data_.size()) fail_end();
    const std::string packed = first(end);
    std::string bytes(size, '\0');
    std::size_t from = numbers * coding_.head_bytes, to = 0;
    for (std::size_t b = 0; b < blocks; ++b) {
      const std::size_t length = b + 1 < blocks ? block : last;
      inflate_block(packed.substr(from, sizes[3 + b]), bytes.data() + to, length);
      from += sizes[3 + b], to += length;
    }
    return bytes;
  }

 private:
  std::string_view data_;
  bool base64_;
  const VtuCoding& coding_;

  static std::string bytes_text(std::uint64_t size) { return std::to_string(size) + " bytes"; }
  [[noreturn]] static void fail_end() { throw VtuFault{"data that end too early", "as many as their head says"}; }
  static void check_size(std::uint64_t found, std::uint64_t expected) {
    if (found != expected) throw VtuFault{bytes_text(found), bytes_text(expected)};
  }

  // The first bytes of head and data.
  std::string first(std::size_t size) const {
    std::string bytes = base64_ ? decoded(data_, size) : std::string(data_.substr(0, size));
    if (bytes.size() < size) fail_end();
    bytes.resize(size);
    return bytes;
  }

  std::vector<std::uint64_t> head(std::size_t count) const {
    const std::string bytes = first(count * coding_.head_bytes);
    std::vector<std::uint64_t> numbers(count, 0);
    for (std::size_t i = 0; i < count; ++i) std::memcpy(&numbers[i], bytes.data() + i * coding_.head_bytes, coding_.head_bytes);
    return numbers;
  }

  static void inflate_block(const std::string& packed, char* to, std::size_t size) {
    uLongf length = size;
    const int result =
        uncompress(reinterpret_cast<Bytef*>(to), &length, reinterpret_cast<const Bytef*>(packed.data()), packed.size());
    if (result != Z_OK || length != size)
      throw VtuFault{"a compressed block that is damaged", "zlib data of " + bytes_text(size)};
  }
};

}  // namespace

std::string vtu_bytes(std::string_view data, bool base64, const VtuCoding& coding, std::size_t size) {
  const Array array(data, base64, coding);
  return coding.zlib ? array.inflated(size) : array.plain(size);
}

}  // namespace unibody
