// Crowds and very many cells, on ranks.
#include <gtest/gtest.h>

#include <numeric>

#include "partition/bisection.hpp"
#include "partition/partition.hpp"
#include "partition/ranks.hpp"
#include "report/state_hash.hpp"
#include "small_worlds.hpp"

namespace unibody::small_worlds::ranks_crowds_test {

namespace {

// Two crowds of boxes and balls over a plate, their bodies spread over the ranks by their ids.
TEST(RanksCrowds, TheSameBitsOnAnyNumberOfRanks) {
  for (const char* solver : {"accelerated_jacobi", "gauss_seidel"}) {
    const Scene scene = scene_from_text("solver: {iterations: 10, name: " + std::string(solver) +
                                        "}\nbodies:\n  - {shape: {plane: {normal: [0, 0, 1]}}}\n  - {shape: {box: {size: [1, 1, "
                                        "0.1]}}, mass: 5, position: [0, 0, 0.1]}\n"
                                        "  - {shape: {sphere: {radius: 0.05}}, mass: 1, lattice: {count: 80, columns: [1, 1], "
                                        "spacing: [1, 1, 1.0e-3], jitter: 0.03}, "
                                        "position: [0, 0, 0.2]}\n"
                                        "  - {shape: {box: {size: [0.1, 0.2, 0.1]}}, mass: 1, lattice: {count: 40, columns: [1, "
                                        "1], spacing: [1, 1, 1.0e-3], jitter: 0.05}, "
                                        "position: [0.1, 0, 0.25]}\n");
    Experiment one(scene), many(scene, MPI_COMM_WORLD);
    for (const std::uint64_t seed : {1u, 2u}) {
      std::vector<int> home(many.world().homes);
      for (std::size_t i = 0; i < home.size(); ++i) home[i] = random_home(many.world().id[i], seed, rank_count());
      many.simulation->move_homes(home);
      for (int k = 0; k < 6; ++k) {
        one.step(), many.step();
        EXPECT_EQ(one.simulation->is_crowded(), many.simulation->is_crowded());
        ASSERT_EQ(state_hash(MPI_COMM_SELF, one.world()), state_hash(MPI_COMM_WORLD, many.world()))
            << solver << ' ' << seed << ' ' << k;
      }
    }
  }
}

// 2.3 million bodies, a cell of space each: the sum of their weights once passed what METIS adds up in.
TEST(RanksPartition, MillionsOfCellsAreSharedOut) {
  if (rank_count() != 2) return;  // it takes seconds
  const std::int64_t all = 2'300'000, ranks = rank_count(), first = all * rank_here() / ranks,
                     last = all * (rank_here() + 1) / ranks;
  std::vector<Vec3> places;
  for (std::int64_t k = first; k < last; ++k)
    places.emplace_back(3.0 * static_cast<double>(k % 200), 3.0 * static_cast<double>(k / 200 % 200),
                        3.0 * static_cast<double>(k / 40'000));
  const std::vector<float> cost(places.size(), 1000.f);
  const std::vector<int> home = partition_bodies(MPI_COMM_WORLD, places, cost, 1.0);
  std::vector<std::int64_t> count(static_cast<std::size_t>(ranks), 0);
  for (const int r : home) ++count[static_cast<std::size_t>(r)];
  MPI_Allreduce(MPI_IN_PLACE, count.data(), static_cast<int>(ranks), MPI_INT64_T, MPI_SUM, MPI_COMM_WORLD);
  for (const std::int64_t n : count)
    EXPECT_NEAR(static_cast<double>(n), static_cast<double>(all / ranks), 0.05 * static_cast<double>(all / ranks));
}

TEST(RanksPartition, BisectionIsEvenAndCoversAll) {
  std::vector<Bisection::Place> cells;
  std::vector<std::int64_t> weights;
  for (std::int32_t x = 0; x < 40; ++x)
    for (std::int32_t y = 0; y < 10; ++y)
      for (std::int32_t z = -5; z < 5; ++z) cells.push_back({x, y, z}), weights.push_back(1 + (x * 7 + y * 3 + z + 5) % 5);
  const auto whole = static_cast<double>(std::accumulate(weights.begin(), weights.end(), std::int64_t{0}));
  for (const int parts : {1, 2, 3, 7, 64}) {
    const Bisection planes(MPI_COMM_SELF, cells, weights, std::vector<int>(static_cast<std::size_t>(parts), 1));
    std::vector<double> load(static_cast<std::size_t>(parts), 0);
    for (std::size_t i = 0; i < cells.size(); ++i)
      load.at(static_cast<std::size_t>(planes.part_of(cells[i]))) += static_cast<double>(weights[i]);
    for (const double w : load)
      EXPECT_NEAR(w, whole / parts, 3 * 6.0) << parts;  // half of the heaviest cell a cut, and fewer than 6 cuts
  }
  const std::vector<Bisection::Place> same(5, {1, 2, 3});
  const Bisection weightless(MPI_COMM_SELF, same, std::vector<std::int64_t>(5, 0), std::vector<int>(3, 1));
  EXPECT_LT(weightless.part_of({1, 2, 3}), 3);
}

}  // namespace

}  // namespace unibody::small_worlds::ranks_crowds_test
