// The binary arrays of VTK's XML files: a head that tells the size, then the data; both in base64 or raw.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace unibody {

struct VtuCoding {
  std::size_t head_bytes = 4;  // of each number in the head: 4 (UInt32) or 8 (UInt64)
  bool zlib = false;           // compressed in blocks
};

// What is wrong with an array; the reader adds the place.
struct VtuFault {
  std::string found, expected;
};

// The array that stands first in the data, which may go on behind it. Throws VtuFault unless it is `size` bytes long.
std::string vtu_bytes(std::string_view data, bool base64, const VtuCoding& coding, std::size_t size);

}  // namespace unibody
