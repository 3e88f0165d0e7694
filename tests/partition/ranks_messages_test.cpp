// Exchanges between ranks that do not know of each other.
#include <gtest/gtest.h>

#include <chrono>
#include <random>
#include <thread>

#include "partition/messages.hpp"
#include "partition/ranks.hpp"

namespace unibody::ranks_messages_test {

namespace {

struct Word {
  int from, to, round, place;
  bool operator==(const Word&) const = default;
};

// What rank `from` sends to rank `to` in a round: of every third pair nothing.
std::vector<Word> letter(int from, int to, int round) {
  std::vector<Word> words;
  const int count = (from + 2 * to + round) % 3 == 0 ? 0 : 1 + (7 * from + 3 * to + 11 * round) % 40;
  for (int k = 0; k < count; ++k) words.push_back({from, to, round, k});
  return words;
}

}  // namespace

// Of rounds that follow each other at once, with the same tag, while ranks are late by turns: a rank that is ahead sends for the
// next round while another still receives for this one.
TEST(RanksMessages, ListsArriveInTheRoundTheyAreSentIn) {
  const int here = rank_here(), ranks = rank_count();
  std::minstd_rand random(static_cast<unsigned>(here + 1));
  for (int round = 0; round < 200; ++round) {
    if (round % 20 == 5 * here) std::this_thread::sleep_for(std::chrono::milliseconds(3));
    ListsByRank<Word> to, expected;
    for (int r = 0; r < ranks; ++r) {
      to[r] = letter(here, r, round);
      if (const auto words = letter(r, here, round); !words.empty()) expected[r] = words;
    }
    ASSERT_EQ(exchange_lists(MPI_COMM_WORLD, to, 901), expected) << "round " << round << ", rank " << here;
  }
}

TEST(RanksMessages, AllOfRanksComeInTheirOrder) {
  const int here = rank_here(), ranks = rank_count();
  for (const int silent : {-1, 0, ranks - 1}) {
    std::vector<Word> mine, expected;
    for (int r = 0; r < ranks; ++r)
      for (int k = 0; k < 3 * r + 1 && r != silent; ++k) expected.push_back({r, 0, 0, k});
    for (const Word& w : expected)
      if (w.from == here) mine.push_back(w);
    EXPECT_EQ(all_of_ranks<Word>(MPI_COMM_WORLD, mine), expected);
  }
  EXPECT_TRUE(all_of_ranks<Word>(MPI_COMM_WORLD, {}).empty());
}

}  // namespace unibody::ranks_messages_test
