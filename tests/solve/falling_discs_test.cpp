// 100 discs that fall between walls: how fast three solvers converge, step by step on their own trajectories, as an independent
// double-precision code found them. The fall is chaotic: 15 % up to 20 iterations, 40 % at 50.
#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "solve/discs_bench.hpp"

namespace unibody::small_worlds::falling_discs_test {

namespace {

constexpr std::array<std::size_t, 5> counts{1, 5, 10, 20, 50};
using Shares = std::array<double, 5>;

// Mean over the steps of the error after these counts of iterations, over the largest of that step; steps without one do not
// count.
Shares fall(double mu, const std::function<std::vector<double>(Discs&)>& solve) {
  Discs discs(
      mu, [](int i, int j) { return Vec3(.3 + .26 * i + .02 * std::sin(7 * j + 3 * i), 0, .3 + .25 * j); },
      [](int, int) { return Vec3::Zero(); });
  Shares sum{};
  int steps = 0;
  for (int frame = 0; frame < 200; ++frame) {
    const std::vector<double> errors = solve(discs);
    const double most = *std::max_element(errors.begin(), errors.end());
    discs.move();
    if (most == 0) continue;
    ++steps;
    for (std::size_t n = 0; n < counts.size(); ++n) sum[n] += errors[counts[n]] / most;
  }
  for (double& share : sum) share /= steps;
  return sum;
}

void expect_shares(const Shares& found, const Shares& expected) {
  for (std::size_t n = 0; n < counts.size(); ++n)
    EXPECT_NEAR(found[n], expected[n], (counts[n] < 50 ? .15 : .4) * expected[n]) << "after " << counts[n] << " iterations";
}

std::vector<double> sweep(Discs& discs) { return discs.errors_of_gauss_seidel(Discs::Gaps::each_sweep); }

}  // namespace

TEST(FallingDiscs, GaussSeidel) { expect_shares(fall(.3, sweep), {.635, .401, .315, .228, .126}); }

TEST(FallingDiscs, Jacobi) {
  expect_shares(fall(0, [](Discs& discs) { return discs.errors(jacobi); }), {.943, .883, .850, .797, .672});
  expect_shares(fall(.3, [](Discs& discs) { return discs.errors(jacobi); }), {.949, .895, .869, .835, .760});
}

TEST(FallingDiscs, AcceleratedJacobi) {
  expect_shares(fall(0, [](Discs& discs) { return discs.errors(accelerated_jacobi); }), {.810, .555, .435, .307, .108});
  expect_shares(fall(.3, [](Discs& discs) { return discs.errors(accelerated_jacobi); }), {.777, .529, .404, .292, .082});
}

}  // namespace unibody::small_worlds::falling_discs_test
