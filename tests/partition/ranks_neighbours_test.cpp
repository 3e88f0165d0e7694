// Who has bodies near whose: beside every pair of bounds compared.
#include <gtest/gtest.h>

#include <cmath>
#include <numeric>
#include <random>
#include <set>

#include "partition/neighbours.hpp"
#include "partition/ranks.hpp"

namespace unibody::ranks_neighbours_test {

namespace {

struct Owned {
  Bounds bounds;
  int rank;
};

// Whether bounds that are made larger by `more` (m) on all sides meet others.
bool meet(const Bounds& a, const Bounds& b, double more = 0) {
  return (a.lower.array() - more <= b.upper.array()).all() && (b.lower.array() <= a.upper.array() + more).all();
}

ListsByRank<std::int32_t> near(const std::vector<Bounds>& mine, const CellSizes& sizes) {
  std::vector<std::int32_t> of(mine.size());
  std::iota(of.begin(), of.end(), 0);
  return bodies_near_ranks(MPI_COMM_WORLD, mine, of, sizes);
}

std::vector<Owned> all_bounds(const std::vector<Bounds>& mine) {
  std::vector<Owned> owned;
  for (const Bounds& b : mine) owned.push_back({b, rank_here()});
  return all_of_ranks<Owned>(MPI_COMM_WORLD, owned);
}

void expect_found(const std::vector<Bounds>& mine, const CellSizes& sizes) {
  const auto found = near(mine, sizes);
  EXPECT_FALSE(found.contains(rank_here()));
  for (const auto& [rank, bodies] : found) {
    EXPECT_FALSE(bodies.empty());
    EXPECT_TRUE(std::ranges::is_sorted(bodies));
  }
  for (const Owned& other : all_bounds(mine))
    for (std::size_t i = 0; i < mine.size() && other.rank != rank_here(); ++i) {
      if (!meet(mine[i], other.bounds)) continue;
      const auto there = found.find(other.rank);
      ASSERT_TRUE(there != found.end() && std::ranges::binary_search(there->second, static_cast<std::int32_t>(i)))
          << "body " << i << " of rank " << rank_here() << " is near rank " << other.rank;
    }
}

Bounds around(const Vec3& centre, double half) { return {centre.array() - half, centre.array() + half}; }

}  // namespace

TEST(RanksNeighbours, AllBoundsThatOverlapAreFound) {
  for (const std::int64_t side : {1, 3, 7})
    for (unsigned seed = 0; seed < 4; ++seed) {
      std::mt19937 random(100 * seed + static_cast<unsigned>(rank_here()));
      std::uniform_real_distribution<double> place(-20, 20), exponent(-1.5, seed < 2 ? 0.3 : 1.5);
      std::vector<Bounds> mine;
      for (int i = 0; i < 150; ++i)
        mine.push_back(around({place(random), place(random), place(random)}, std::pow(10, exponent(random))));
      expect_found(mine, {1.0, side});
    }
}

// The bodies fill a row, of which each rank has ten in sequence. Bodies next to each other touch by their faces, which lie on a
// border between cells or inside a cell, as the size of the cells has it.
TEST(RanksNeighbours, TouchingFacesAreFound) {
  for (const double cell : {0.5, 1.0, 0.3}) {
    std::vector<Bounds> mine;
    for (int i = 0; i < 10; ++i) mine.push_back(around({10.0 * rank_here() + i + 0.5, 0, 0}, 0.5));
    expect_found(mine, {cell, 4});
    const auto found = near(mine, {cell, 4});
    for (const auto& [rank, bodies] : found) {
      EXPECT_EQ(std::abs(rank - rank_here()), 1);
      EXPECT_EQ(bodies, std::vector<std::int32_t>{rank > rank_here() ? 9 : 0});
    }
    EXPECT_EQ(found.size(), static_cast<std::size_t>((rank_here() > 0) + (rank_here() + 1 < rank_count())));
  }
}

// Only what comes within a cell is taken beside: clusters that lie apart have nothing to do with each other, whatever bounds
// hold a rank's bodies together.
TEST(RanksNeighbours, AStrayBodyIsNearNobody) {
  std::mt19937 random(static_cast<unsigned>(rank_here()));
  std::uniform_real_distribution<double> place(-2, 2);
  std::vector<Bounds> mine;
  for (int i = 0; i < 100; ++i)
    mine.push_back(around(Vec3(100.0 * rank_here() + place(random), place(random), place(random)), 0.2));
  mine.push_back(around({100.0 * (rank_count() - rank_here()) + 30, 0, 0}, 0.2));  // among the others' clusters
  EXPECT_TRUE(near(mine, {0.5, 3}).empty());
}

// A plate that is under all bodies, of one rank, and the image of a body.
TEST(RanksNeighbours, HugeBodiesAndImages) {
  std::vector<Bounds> mine;
  for (int i = 0; i < 20; ++i) mine.push_back(around({100.0 * rank_here() + 3 * i, 0, 0.5}, 0.5));
  if (rank_here() == 0) mine.push_back({{-1e4, -1e4, -1}, {1e4, 1e4, 0}});
  expect_found(mine, {1.0, 4});
  const auto found = near(mine, {1.0, 4});
  if (rank_here() > 0) {
    EXPECT_EQ(found.at(0).size(), 20u);
  }
  // A body in two places is named once.
  const std::vector<Bounds> places{around({0, 0, 0}, 0.5), around({0.25, 0, 0}, 0.5),
                                   around({1000.0 * (1 + rank_here()), 0, 0}, 0.5)};
  const std::vector<std::int32_t> of{5, 5, 6};
  const auto images = bodies_near_ranks(MPI_COMM_WORLD, places, of, {1.0, 2});
  EXPECT_EQ(images.size(), static_cast<std::size_t>(rank_count() - 1));
  for (const auto& [rank, bodies] : images) EXPECT_EQ(bodies, std::vector<std::int32_t>{5});
}

}  // namespace unibody::ranks_neighbours_test
