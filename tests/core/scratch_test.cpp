#include "core/scratch.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <numeric>

namespace unibody::scratch_test {
namespace {

using Numbers = std::pmr::vector<std::int64_t>;

void fill_and_check(Scratch& scratch, std::size_t n) {
  const Scratch::Frame frame(scratch);
  Numbers a(n, 1, &scratch), b(n, 2, &scratch);
  {
    const Scratch::Frame inner(scratch);
    const Numbers c(3 * n, 3, &scratch);
    EXPECT_EQ(std::accumulate(c.begin(), c.end(), std::int64_t{0}), static_cast<std::int64_t>(9 * n));
  }
  const Numbers d(n, 4, &scratch);  // where c was
  for (const Numbers* v : {static_cast<const Numbers*>(&a), static_cast<const Numbers*>(&b), &d})
    EXPECT_EQ(std::accumulate(v->begin(), v->end(), std::int64_t{0}), static_cast<std::int64_t>(n) * v->front());
}

TEST(Scratch, HoldsTheMostThatWasInUseAtOnce) {
  Scratch scratch;
  EXPECT_EQ(scratch.bytes(), 0u);
  for (const std::size_t n : {100u, 1000u, 100000u, 10u}) fill_and_check(scratch, n);
  EXPECT_GE(scratch.bytes(), 5 * 8 * 100000u);
  EXPECT_LT(scratch.bytes(), 5 * 8 * 110000u);
  const std::size_t before = scratch.bytes();
  for (int k = 0; k < 3; ++k) fill_and_check(scratch, 100000);
  EXPECT_EQ(scratch.bytes(), before);
}

TEST(Scratch, KeepsToTheAlignmentAskedFor) {
  struct alignas(64) Line {
    char bytes[64];
  };
  Scratch scratch;
  for (int k = 0; k < 2; ++k) {  // at first outside of the block, then inside
    const Scratch::Frame frame(scratch);
    const std::pmr::vector<char> odd(3, &scratch);
    const std::pmr::vector<Line> lines(5, &scratch);
    EXPECT_EQ(reinterpret_cast<std::uintptr_t>(lines.data()) % 64, 0u);
  }
}

}  // namespace
}  // namespace unibody::scratch_test
