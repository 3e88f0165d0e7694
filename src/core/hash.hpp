// A 64-bit streaming hash for comparing states and texts; not for adversaries.
#pragma once

#include <bit>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>

namespace unibody {

class Hash {
 public:
  Hash& add(std::uint64_t word) {
    ++words_;
    state_ = mix(state_ ^ mix(word + words_ * 0x9e3779b97f4a7c15));
    return *this;
  }
  Hash& add(std::int64_t word) { return add(static_cast<std::uint64_t>(word)); }
  Hash& add(double x) { return add(std::bit_cast<std::uint64_t>(x)); }  // tells -0 from 0
  Hash& add(std::string_view text) {
    add(static_cast<std::uint64_t>(text.size()));
    std::size_t k = 0;
    if constexpr (std::endian::native == std::endian::little)
      for (; k + 8 <= text.size(); k += 8) {
        std::uint64_t word;
        std::memcpy(&word, text.data() + k, 8);
        add(word);
      }
    for (; k < text.size(); k += 8) {
      std::uint64_t word = 0;
      for (std::size_t c = k; c < text.size() && c < k + 8; ++c)
        word |= std::uint64_t{static_cast<unsigned char>(text[c])} << 8 * (c - k);
      add(word);
    }
    return *this;
  }
  std::uint64_t value() const { return mix(state_ ^ words_); }

 private:
  // The finaliser of MurmurHash3 with Stafford's constants (variant 13): a bijection in which each bit reaches all others.
  static constexpr std::uint64_t mix(std::uint64_t x) {
    x = (x ^ x >> 30) * 0xbf58476d1ce4e5b9;
    x = (x ^ x >> 27) * 0x94d049bb133111eb;
    return x ^ x >> 31;
  }
  std::uint64_t state_ = 0x756e69626f6479, words_ = 0;
};

// 16 hex digits, as reports and file attributes print a hash.
inline std::string hex(std::uint64_t value) {
  std::string text(16, '0');
  for (int k = 15; k >= 0; --k, value >>= 4) text[static_cast<std::size_t>(k)] = "0123456789abcdef"[value & 15];
  return text;
}

}  // namespace unibody
