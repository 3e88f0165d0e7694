#include "core/hash.hpp"

#include <gtest/gtest.h>

#include <set>

namespace unibody::hash_test {
namespace {

TEST(Hash, EveryBitAndTheOrderCount) {
  std::set<std::uint64_t> seen{Hash().value(), Hash().add(std::uint64_t{0}).value()};
  for (int bit = 0; bit < 64; ++bit) seen.insert(Hash().add(std::uint64_t{1} << bit).value());
  seen.insert(Hash().add(std::uint64_t{0}).add(std::uint64_t{0}).value());
  seen.insert(Hash().add(std::uint64_t{1}).add(std::uint64_t{2}).value());
  seen.insert(Hash().add(std::uint64_t{2}).add(std::uint64_t{1}).value());
  EXPECT_EQ(seen.size(), 69u);
  EXPECT_NE(Hash().add(0.0).value(), Hash().add(-0.0).value());
}

TEST(Hash, Texts) {
  std::set<std::uint64_t> seen;
  for (const char* text : {"", "a", "b", "ab", "ba", "12345678", "123456789", "12345678 ", "1234567"})
    seen.insert(Hash().add(std::string_view(text)).value());
  EXPECT_EQ(seen.size(), 9u);
  EXPECT_EQ(hex(0x1234), "0000000000001234");
}

}  // namespace
}  // namespace unibody::hash_test
