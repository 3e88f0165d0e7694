#include "core/largest.hpp"

#include <gtest/gtest.h>

#include <array>
#include <limits>

#include "core/checked.hpp"

namespace unibody::largest_test {
namespace {

constexpr double no_number = std::numeric_limits<double>::quiet_NaN();

int rank_here() {
  int rank = 0;
  check_mpi(MPI_Comm_rank(MPI_COMM_WORLD, &rank));
  return rank;
}

// Each rank in turn is the one whose value is no number: with MPI_MAX alone what comes out depends on which.
TEST(RanksLargest, WhatIsNoNumberCountsAsInfiniteOnEveryRank) {
  int ranks = 0;
  check_mpi(MPI_Comm_size(MPI_COMM_WORLD, &ranks));
  for (int who = 0; who < ranks; ++who) {
    const bool mine = rank_here() == who;
    std::array values{mine ? no_number : 2.0, 1.0 + rank_here(), mine ? 7.0 : -1.0};
    make_largest(MPI_COMM_WORLD, values);
    EXPECT_EQ(values[0], HUGE_VAL) << who;
    EXPECT_EQ(values[1], ranks) << who;
    EXPECT_EQ(values[2], 7.0) << who;
    EXPECT_EQ(smallest_of_ranks(MPI_COMM_WORLD, mine ? no_number : 2.0), -HUGE_VAL) << who;
  }
  EXPECT_EQ(smallest_of_ranks(MPI_COMM_WORLD, 3.0 + rank_here()), 3.0);
}

}  // namespace
}  // namespace unibody::largest_test
