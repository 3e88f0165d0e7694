// A partition in groups: the planes that cut space into them, and the cut of each.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <set>

#include "partition/bisection.hpp"
#include "partition/messages.hpp"
#include "partition/partition.hpp"
#include "partition/ranks.hpp"

namespace unibody::ranks_groups_test {

namespace {

struct Placed {
  Vec3 position;
  Patch patch;
  int home;
};

std::vector<Placed> placed(const std::vector<Vec3>& positions, const std::vector<Patch>& patches, const std::vector<int>& home) {
  std::vector<Placed> mine;
  for (std::size_t i = 0; i < home.size(); ++i) mine.push_back({positions[i], patches.empty() ? Patch{} : patches[i], home[i]});
  return all_of_ranks<Placed>(MPI_COMM_WORLD, mine);
}

// Bodies of the cells of a cube, thrown about on the ranks; those of a cell lie together but on several ranks.
std::vector<Vec3> lattice(int side) {
  std::vector<Vec3> mine;
  for (int i = 0; i < 8 * side * side * side; ++i)
    if (i % rank_count() == rank_here()) {
      const int cell = i / 8;
      mine.push_back(Vec3(cell % side, cell / side % side, cell / (side * side)) + Vec3::Constant(0.1 + 0.1 * (i % 8)));
    }
  return mine;
}

double heaviest_share(const std::vector<Placed>& all) {
  std::vector<double> load(static_cast<std::size_t>(rank_count()), 0);
  for (const Placed& p : all) load[static_cast<std::size_t>(p.home)] += 1;
  return *std::ranges::max_element(load) * rank_count() / static_cast<double>(all.size());
}

}  // namespace

// Of weights that differ by a hundred, half of the cells in one plane, by shares that differ: each part has its share, to within
// a cell for each of the cuts that made it. And each cell has the part that one rank with all cells finds.
TEST(RanksBisection, PartsHaveTheirShares) {
  std::mt19937 random(7 + static_cast<unsigned>(rank_here()));
  std::uniform_int_distribution<std::int32_t> coordinate(-40, 40);
  std::uniform_int_distribution<std::int64_t> weight(1, 100);
  struct Weighed {
    Bisection::Place place;
    std::int64_t weight;
  };
  std::vector<Bisection::Place> places;
  std::vector<std::int64_t> weights;
  std::vector<Weighed> mine;
  for (int i = 0; i < 800; ++i) {
    places.push_back({coordinate(random), coordinate(random), i % 2 == 0 ? 3 : coordinate(random)});
    weights.push_back(weight(random));
    mine.push_back({places.back(), weights.back()});
  }
  const std::vector<int> shares{1, 1, 3, 2, 4, 1, 5};
  const Bisection parts(MPI_COMM_WORLD, places, weights, shares);
  const auto all = all_of_ranks<Weighed>(MPI_COMM_WORLD, mine);
  places.clear(), weights.clear();
  std::map<Bisection::Place, double> of_cell;
  std::vector<double> load(shares.size(), 0);
  for (const Weighed& w : all) {
    places.push_back(w.place), weights.push_back(w.weight);
    of_cell[w.place] += static_cast<double>(w.weight);
    load[static_cast<std::size_t>(parts.part_of(w.place))] += static_cast<double>(w.weight);
  }
  const Bisection alone(MPI_COMM_SELF, places, weights, shares);
  double total = 0, heaviest = 0;
  for (const auto& [place, w] : of_cell) {
    total += w, heaviest = std::max(heaviest, w);
    ASSERT_EQ(parts.part_of(place), alone.part_of(place));
  }
  for (std::size_t p = 0; p < shares.size(); ++p)
    EXPECT_NEAR(load[p], total * shares[p] / 17, 3 * heaviest) << "part " << p;  // seven parts by three levels of cuts
}

// Eight cubes of cells by three cuts each.
TEST(RanksBisection, CutsACubeByPlanes) {
  std::vector<Bisection::Place> places;
  for (std::int32_t i = 0; i < 512; ++i)
    if (i % rank_count() == rank_here()) places.push_back({i % 8, i / 8 % 8 - 2, 1000000000 + i / 64});
  const Bisection parts(MPI_COMM_WORLD, places, std::vector<std::int64_t>(places.size(), 1), std::vector<int>(8, 1));
  std::map<int, std::set<Bisection::Place>> octants;
  for (std::int32_t i = 0; i < 512; ++i) {
    const Bisection::Place place{i % 8, i / 8 % 8 - 2, 1000000000 + i / 64};
    octants[parts.part_of(place)].insert({i % 8 / 4, i / 8 % 8 / 4, i / 64 / 4});
  }
  ASSERT_EQ(octants.size(), 8u);
  for (const auto& [part, where] : octants) EXPECT_EQ(where.size(), 1u) << "part " << part;
}

TEST(RanksBisection, OneCellAndNoneAreLegal) {
  const std::vector<int> shares(5, 1);
  const Bisection none(MPI_COMM_WORLD, {}, {}, shares);
  EXPECT_LT(none.part_of({1, 2, 3}), 5);
  const std::vector<Bisection::Place> place{{1, 2, 3}};
  const std::vector<std::int64_t> weight{7};
  const bool has_it = rank_here() == rank_count() - 1;
  const Bisection one(MPI_COMM_WORLD, has_it ? std::span(place) : std::span<const Bisection::Place>{},
                      has_it ? std::span(weight) : std::span<const std::int64_t>{}, shares);
  EXPECT_LT(one.part_of({1, 2, 3}), 5);
}

TEST(RanksGroups, PartsAreEvenAndCellsWhole) {
  for (const GroupLimits limits : {GroupLimits{1, 1 << 18}, GroupLimits{2, 1 << 18}, GroupLimits{64, 200}, GroupLimits{64, 1}}) {
    const std::vector<Vec3> mine = lattice(10);
    const std::vector<int> home =
        partition_bodies(MPI_COMM_WORLD, mine, std::vector<float>(mine.size(), 20), 1.0, {}, {}, {}, limits);
    const auto all = placed(mine, {}, home);
    ASSERT_EQ(all.size(), 8000u);
    EXPECT_LT(heaviest_share(all), 1.03) << limits.parts << " parts, " << limits.cells << " cells";
    std::map<std::array<int, 3>, int> of_cell;
    for (const Placed& p : all) {
      const std::array cell{static_cast<int>(p.position.x()), static_cast<int>(p.position.y()), static_cast<int>(p.position.z())};
      const auto [found, is_new] = of_cell.emplace(cell, p.home);
      ASSERT_EQ(found->second, p.home);
    }
    // Each part is a region: one more has at most a plane of 100 faces more to others, and a step of a fifth of it.
    int cut = 0;
    for (const auto& [cell, rank] : of_cell)
      for (std::size_t k = 0; k < 3; ++k) {
        auto next = cell;
        ++next[k];
        cut += of_cell.contains(next) && of_cell.at(next) != rank;
      }
    EXPECT_LE(cut, 120 * (rank_count() - 1)) << limits.parts << " parts, " << limits.cells << " cells";
  }
}

// A body that has gone a million cells away does not spoil the cut of the others.
TEST(RanksGroups, AStrayBodySpoilsNothing) {
  std::vector<Vec3> mine = lattice(10);
  if (rank_here() == 0) mine.emplace_back(2e9, -1e8, 5e8);
  const std::vector<float> cost(mine.size(), 20);
  const auto all = placed(mine, {}, partition_bodies(MPI_COMM_WORLD, mine, cost, 1.0, {}, {}, {}, {1, 1 << 18}));
  EXPECT_LT(heaviest_share(all), 1.03);
}

// Patches of a cloth of 40 x 40 nodes, whose nodes are thrown about on the ranks.
TEST(RanksGroups, PatchesStayWhole) {
  std::vector<Vec3> mine;
  std::vector<Patch> patches;
  std::vector<PatchLink> links;
  const auto patch_at = [](int x, int y) { return Patch{0, x / 4 + 10 * (y / 4)}; };
  for (int i = 0; i < 1600; ++i) {
    const int x = i % 40, y = i / 40;
    if (i % rank_count() != rank_here()) continue;
    mine.emplace_back(0.1 * x, 0.1 * y, 0);
    patches.push_back(patch_at(x, y));
    for (const Patch& next : {patch_at(std::min(x + 1, 39), y), patch_at(x, std::min(y + 1, 39))})
      if (next.number != patches.back().number) links.push_back({patches.back(), next, 10});
  }
  for (const GroupLimits limits : {GroupLimits{1, 1 << 18}, GroupLimits{2, 1 << 18}, GroupLimits{}}) {
    const auto home =
        partition_bodies(MPI_COMM_WORLD, mine, std::vector<float>(mine.size(), 20), 0.4, patches, links, {}, limits);
    const auto all = placed(mine, patches, home);
    EXPECT_LT(heaviest_share(all), 1.1);
    std::map<Patch, int> of_patch;
    for (const Placed& p : all) {
      const auto [found, is_new] = of_patch.emplace(p.patch, p.home);
      ASSERT_EQ(found->second, p.home);
    }
    EXPECT_EQ(of_patch.size(), 100u);
  }
}

// Homes that are good already stay: the parts are numbered by who has what.
TEST(RanksGroups, WhatLiesWellStays) {
  const std::vector<Vec3> start = lattice(10);
  const GroupLimits limits{2, 1 << 18};
  const auto all =
      placed(start, {}, partition_bodies(MPI_COMM_WORLD, start, std::vector<float>(start.size(), 20), 1.0, {}, {}, {}, limits));
  std::vector<Vec3> mine;
  for (const Placed& p : all)
    if (p.home == rank_here()) mine.push_back(p.position);
  const auto again = partition_bodies(MPI_COMM_WORLD, mine, std::vector<float>(mine.size(), 20), 1.0, {}, {}, {}, limits);
  const auto stay = std::ranges::count(again, rank_here());
  EXPECT_GT(static_cast<double>(stay), 0.9 * static_cast<double>(mine.size()));
}

}  // namespace unibody::ranks_groups_test
