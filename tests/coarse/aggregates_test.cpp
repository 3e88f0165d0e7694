// The parts of flexible bodies that the coarse level moves as rigid ones.
#include "coarse/aggregates.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>

namespace unibody::aggregates_test {

namespace {

std::vector<Vec3> grid(int nx, int ny, int nz) {
  std::vector<Vec3> points;
  for (int k = 0; k < nz; ++k)
    for (int j = 0; j < ny; ++j)
      for (int i = 0; i < nx; ++i) points.emplace_back(i, j, k);
  return points;
}

// The longest edge of the box about each aggregate, in distances of neighbours.
double longest_extent(const std::vector<Vec3>& points, const std::vector<std::int32_t>& number) {
  std::map<std::int32_t, Eigen::AlignedBox3d> boxes;
  for (std::size_t i = 0; i < points.size(); ++i) boxes[number[i]].extend(points[i]);
  double longest = 0;
  for (const auto& [a, box] : boxes) longest = std::max(longest, box.sizes().maxCoeff());
  return longest;
}

}  // namespace

// 64 x 64 nodes of a cloth are 8 x 8 squares, 16 x 16 x 16 of a solid 4 x 4 x 4 cubes, of 64 nodes each.
TEST(Aggregates, AreSquaresOfClothsAndCubesOfSolids) {
  for (const auto& [points, extent] : {std::pair{grid(64, 64, 1), 7.0}, {grid(16, 16, 16), 3.0}}) {
    const std::vector<std::int32_t> number = aggregate_points(points);
    std::map<std::int32_t, int> sizes;
    for (const std::int32_t a : number) ++sizes[a];
    EXPECT_EQ(sizes.size(), 64u);
    for (const auto& [a, size] : sizes) EXPECT_EQ(size, 64) << a;
    EXPECT_EQ(longest_extent(points, number), extent);
  }
}

// Where the points do not divide evenly, no aggregate has more of them than one above the limit or fewer than half of it, and the
// aggregates are numbered without gaps.
TEST(Aggregates, HaveAboutTheSameSize) {
  for (const auto& points : {grid(50, 50, 1), grid(1, 1001, 1), grid(7, 11, 13)}) {
    const std::vector<std::int32_t> number = aggregate_points(points);
    const std::size_t count = (points.size() + nodes_of_aggregate - 1) / nodes_of_aggregate;
    std::vector<std::size_t> sizes(count, 0);
    for (const std::int32_t a : number) ++sizes.at(static_cast<std::size_t>(a));
    EXPECT_LE(*std::ranges::max_element(sizes), nodes_of_aggregate + 1);
    EXPECT_GE(*std::ranges::min_element(sizes), nodes_of_aggregate / 2);
  }
  EXPECT_TRUE(aggregate_points({}).empty());
  EXPECT_EQ(aggregate_points(grid(3, 1, 1)), std::vector<std::int32_t>(3, 0));
}

// Points of equal coordinates are told apart by their numbers, so that every rank finds the same parts.
TEST(Aggregates, OfPointsAtOnePlaceAreRunsOfNumbers) {
  const std::vector<Vec3> points(256, Vec3(1, 2, 3));
  const std::vector<std::int32_t> number = aggregate_points(points);
  for (std::size_t i = 0; i < points.size(); ++i) EXPECT_EQ(number[i], static_cast<std::int32_t>(i / 64)) << i;
}

TEST(Aggregates, OfASceneCountOnFromBodyToBody) {
  Aggregates all;
  all.add(1000, grid(16, 16, 1));
  all.add(10, grid(64, 1, 1));
  EXPECT_EQ(all.count(), 5);
  EXPECT_EQ(all.of(9), -1);
  EXPECT_EQ(all.of(10), 4);
  EXPECT_EQ(all.of(73), 4);
  EXPECT_EQ(all.of(74), -1);
  EXPECT_EQ(all.of(999), -1);
  EXPECT_GE(all.of(1000), 0);
  EXPECT_LT(all.of(1255), 4);
  EXPECT_EQ(all.of(1256), -1);
}

}  // namespace unibody::aggregates_test
