// Two cards that lean against each other with sharp edges: they stand where friction bears the force between them.
#include <gtest/gtest.h>

#include <cmath>

#include "small_worlds.hpp"

namespace unibody::small_worlds::leaning_test {

namespace {

constexpr double length = 0.1, thickness = 0.003;

// m, the height of the left card's centre after 2 s; and where it starts.
std::pair<double, double> height(const std::string& solver, int substeps, double angle, double friction, bool planar) {
  const double c = std::cos(angle), s = std::sin(angle);
  const double x = thickness / 2 * c + length / 2 * s, z = thickness / 2 * s + length / 2 * c;
  std::string text = "planar: " + std::string(planar ? "true" : "false") + "\ntime: {substeps: " + std::to_string(substeps) +
                     "}\nsolver: {name: " + solver + "}\nmaterials: {m: {friction: " + std::to_string(friction) +
                     "}}\nbodies:\n  - {shape: {plane: {normal: [0, 0, 1]}}}\n";
  for (const double side : {1.0, -1.0}) {
    const auto digits = [](double value) {
      char digit[32];
      std::snprintf(digit, sizeof digit, "%.15g", value);
      return std::string(digit);
    };
    text += "  - {shape: {box: {size: [0.003, 0.06, 0.1]}}, mass: 0.01, position: [" + digits(-side * x) + ", 0, " + digits(z) +
            "], orientation: {axis: [0, 1, 0], angle: " + digits(side * angle * 180 / M_PI) + "}}\n";
  }
  Experiment run(scene_from_text(text));
  run.seconds(2);
  return {run.position(1).z(), z};
}

}  // namespace

class Leaning : public testing::TestWithParam<std::tuple<const char*, int>> {};

// Between the cards a level force F without friction; on each its weight at half its width, F at its top:
// mu m g = F, F (L c) = m g (L s - t c) / 2.
TEST_P(Leaning, CardsStandByTheFrictionThatTheyNeed) {
  const auto [solver, substeps] = GetParam();
  for (const double degrees : {15., 20., 30.}) {
    const double angle = degrees * M_PI / 180, c = std::cos(angle), s = std::sin(angle);
    const double needed = (length * s - thickness * c) / (2 * length * c);
    for (const bool planar : {false, true})
      for (const double share : {1.05, 1.25, 2.0, 0.9}) {
        const auto [end, start] = height(solver, substeps, angle, share * needed, planar);
        if (share > 1)
          EXPECT_NEAR(end, start, 0.005 * start) << degrees << ' ' << share;
        else
          EXPECT_LT(end, 0.1 * start) << degrees << ' ' << share;  // they lie
      }
  }
}

INSTANTIATE_TEST_SUITE_P(, Leaning,
                         testing::Combine(testing::Values("accelerated_jacobi", "gauss_seidel"), testing::Values(1, 4)));

}  // namespace unibody::small_worlds::leaning_test
