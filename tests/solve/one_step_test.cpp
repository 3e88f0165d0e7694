// One step of 100 discs, solver by solver: errors after k iterations as an independent double-precision code found them.
// The discs fall as a block, 2 mm too deep in each other here and there: 200 candidate contacts, no friction, cold.
#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "solve/discs_bench.hpp"

namespace unibody::small_worlds::one_step_test {

namespace {

Discs falling_block() {
  return Discs(
      0,
      [](int i, int j) {
        return Vec3(.1 + .19 * i + .01 * std::sin(7 * j + 3 * i), 0, .1 + .19 * j + .01 * std::cos(5 * i + 2 * j));
      },
      [](int i, int) { return Vec3(.1 * std::sin(i), 0, -1); });
}

struct Row {
  double k1, k2, k5, k10, k20, k50, sum;
};

void expect_row(const std::vector<double>& found, double sum, const Row& expected) {
  ASSERT_EQ(found.size(), 51u);
  EXPECT_NEAR(found[0], 2.213426378e-1, 1e-8 * 2.2e-1);
  const std::map<std::size_t, double> rows{{1, expected.k1},   {2, expected.k2},   {5, expected.k5},
                                           {10, expected.k10}, {20, expected.k20}, {50, expected.k50}};
  for (const auto& [k, value] : rows) EXPECT_NEAR(found[k], value, 1e-8 * value) << "after " << k << " iterations";
  EXPECT_NEAR(sum, expected.sum, 1e-8 * expected.sum);
}

}  // namespace

TEST(OneStep, HasTwoHundredCandidates) { EXPECT_EQ(falling_block().contacts.manifolds.size(), 200u); }

TEST(OneStep, Jacobi) {
  Discs discs = falling_block();
  const auto errors = discs.errors(jacobi);
  expect_row(errors, discs.sum_of_forces(),
             {1.806929385e-1, 1.565684391e-1, 1.380978735e-1, 1.330365960e-1, 1.271096716e-1, 1.140499065e-1, 4.564418285e4});
}

TEST(OneStep, AcceleratedJacobi) {
  Discs discs = falling_block();
  const auto errors = discs.errors(accelerated_jacobi);
  expect_row(errors, discs.sum_of_forces(),
             {1.806929385e-1, 1.514097685e-1, 1.349644916e-1, 1.258213182e-1, 1.056729766e-1, 3.094319073e-2, 2.251563284e5});
}

TEST(OneStep, GaussSeidel) {
  Discs discs = falling_block();
  const auto errors = discs.errors_of_gauss_seidel(Discs::Gaps::each_contact);
  expect_row(errors, discs.sum_of_forces(),
             {1.505463902e-1, 1.311665912e-1, 1.167830407e-1, 1.029419297e-1, 8.074531198e-2, 3.809218850e-2, 2.103641405e5});
}

}  // namespace unibody::small_worlds::one_step_test
