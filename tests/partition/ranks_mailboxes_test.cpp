// Mailboxes: every letter arrives whole, once and in order, however late one of the two is.
#include <gtest/gtest.h>

#include <chrono>
#include <cstring>
#include <random>
#include <thread>

#include "partition/mailboxes.hpp"
#include "partition/ranks.hpp"

namespace unibody::ranks_mailboxes_test {

namespace {

constexpr std::size_t longest = 4096;

// Of this round, from one rank to another: any length up to the longest, and bytes that no other letter has.
std::vector<std::byte> letter_of(int round, int from, int to) {
  std::minstd_rand random(static_cast<unsigned>(1 + round * 64 + from * 8 + to));
  std::vector<std::byte> letter(random() % (longest + 1));
  for (std::byte& b : letter) b = static_cast<std::byte>(random());
  return letter;
}

// One letter to each other rank and one from each, as often as that.
void expect_all_arrive(Mailboxes& boxes, int rounds) {
  std::minstd_rand pauses(static_cast<unsigned>(17 + rank_here()));
  for (int round = 0; round < rounds; ++round) {
    if (pauses() % 64 == 0) std::this_thread::sleep_for(std::chrono::microseconds(pauses() % 2000));
    for (int other = 0; other < rank_count(); ++other) {
      if (other == rank_here()) continue;
      const auto letter = letter_of(round, rank_here(), other);
      ASSERT_TRUE(boxes.carry(other, letter.size()));
      std::memcpy(boxes.letter(other), letter.data(), letter.size());
      boxes.send(other);
    }
    for (int other = 0; other < rank_count(); ++other) {
      if (other == rank_here()) continue;
      const auto expected = letter_of(round, other, rank_here());
      const std::byte* letter = boxes.receive(other);
      ASSERT_EQ(std::memcmp(letter, expected.data(), expected.size()), 0) << "round " << round << ", from rank " << other;
    }
  }
}

}  // namespace

TEST(RanksMailboxes, EveryLetterArrivesWholeAndInOrder) {
  Mailboxes boxes(MPI_COMM_WORLD, longest);
  EXPECT_EQ(boxes.reach_all(), rank_count() > 1);  // tests run on one machine
  expect_all_arrive(boxes, 1000);
}

TEST(RanksMailboxes, TwoSetsDoNotMix) {
  Mailboxes boxes(MPI_COMM_WORLD, longest), others(MPI_COMM_WORLD, longest);
  expect_all_arrive(boxes, 3);
  expect_all_arrive(others, 20);
  expect_all_arrive(boxes, 20);
}

// The first of two letters stays readable while the other rank already writes the second.
TEST(RanksMailboxes, ALetterStaysUntilTheNextIsReceived) {
  Mailboxes boxes(MPI_COMM_WORLD, 64);
  if (rank_count() < 2 || rank_here() > 1) return;
  const int other = 1 - rank_here();
  const auto send = [&](int number) {
    std::memcpy(boxes.letter(other), &number, sizeof number);
    boxes.send(other);
  };
  const auto number_in = [](const std::byte* letter) {
    int number = 0;
    std::memcpy(&number, letter, sizeof number);
    return number;
  };
  send(10);
  const std::byte* const first = boxes.receive(other);
  send(11);
  std::this_thread::sleep_for(std::chrono::milliseconds(5));  // by now the other's second letter is there
  EXPECT_EQ(number_in(first), 10);
  EXPECT_EQ(number_in(boxes.receive(other)), 11);
}

// As on a cluster: of four ranks 0 and 2 on one node, 1 and 3 on another.
TEST(RanksMailboxes, OtherNodesHaveNoBoxHere) {
  MPI_Comm node = MPI_COMM_NULL;
  MPI_Comm_split(MPI_COMM_WORLD, rank_here() % 2, 0, &node);
  Mailboxes boxes(MPI_COMM_WORLD, longest, node);
  MPI_Comm_free(&node);
  const auto same_node = [](int other) { return other != rank_here() && other % 2 == rank_here() % 2; };
  for (int round = 0; round < 5; ++round) {
    for (int other = 0; other < rank_count(); ++other) {
      if (other != rank_here()) {
        EXPECT_EQ(boxes.carry(other, 8), same_node(other));
      }
      if (!same_node(other)) continue;
      const auto letter = letter_of(round, rank_here(), other);
      std::memcpy(boxes.letter(other), letter.data(), letter.size());
      boxes.send(other);
    }
    for (int other = 0; other < rank_count(); ++other) {
      if (!same_node(other)) continue;
      const auto expected = letter_of(round, other, rank_here());
      EXPECT_EQ(std::memcmp(boxes.receive(other), expected.data(), expected.size()), 0);
    }
  }
  EXPECT_FALSE(boxes.reach_all());
}

TEST(RanksMailboxes, WhatIsTooLongHasNoBox) {
  Mailboxes boxes(MPI_COMM_WORLD, 100), none(MPI_COMM_WORLD, 0), alone(MPI_COMM_SELF, 100);
  for (int other = 0; other < rank_count(); ++other) {
    EXPECT_EQ(boxes.carry(other, 128), rank_count() > 1);  // rounded up to whole cache lines
    EXPECT_FALSE(boxes.carry(other, 129));
    EXPECT_FALSE(none.carry(other, 1));
  }
  EXPECT_FALSE(none.reach_all());
  EXPECT_FALSE(alone.carry(0, 1));
  Mailboxes large(MPI_COMM_WORLD, std::size_t{1} << 30);  // shrinks to what a node's boxes may take
  for (int other = 0; other < rank_count(); ++other) EXPECT_FALSE(large.carry(other, std::size_t{8} << 20));
}

}  // namespace unibody::ranks_mailboxes_test
