// A ball that comes to a rising face loses the energy that the impact takes, and no more, however long the steps are.
#include <gtest/gtest.h>

#include <cmath>
#include <sstream>

#include "small_worlds.hpp"

namespace unibody::small_worlds::edge_crossing_test {

namespace {

constexpr double radius = 0.1, g = 9.81, reach = 2;  // m, m/s^2, m: the last of each face

enum class Ground { boxes, compound, field };

// Level ground up to x = 0, from where it rises at an angle.
std::string ground_of(Ground kind, double angle) {
  std::ostringstream text;
  text.precision(17);
  const auto box = [&](const char* before, double turn, const char* after) {
    const double s = std::sin(turn), c = std::cos(turn), along = turn > 0 ? reach / 2 : -reach / 2;
    text << before << "shape: {box: {size: [" << reach << ", 1, 0.1]}}, position: [" << along * c + 0.05 * s << ", 0, "
         << along * s - 0.05 * c << "], orientation: [" << std::cos(turn / 2) << ", 0, " << -std::sin(turn / 2) << ", 0]"
         << after;
  };
  if (kind == Ground::boxes) {
    box("  - {", 0, ", motion: fixed}\n"), box("  - {", angle, ", motion: fixed}\n");
  } else if (kind == Ground::compound) {
    text << "  - {shape: {compound: {parts: [";
    box("{", 0, "}, "), box("{", angle, "}");
    text << "]}}, motion: fixed, position: [" << 0.5 * (-reach / 2 + reach / 2 * std::cos(angle) + 0.05 * std::sin(angle))
         << ", 0, " << 0.5 * (-0.05 + reach / 2 * std::sin(angle) - 0.05 * std::cos(angle)) << "]}\n";
  } else {
    const double top = reach / 2 * std::tan(angle);
    text << "  - {shape: {mesh: {height_field: {size: [" << reach << ", 1], cells: [2, 1], heights: [0, 0, " << top << ", 0, 0, "
         << top << "]}}}}\n";
  }
  return text.str();
}

class EdgeCrossing : public testing::TestWithParam<std::tuple<const char*, int>> {};

// The energy of a unit of mass at the middle of the step, which keeps it on a plane.
double energy(const Experiment& run, Id ball, double inertia) {
  return 0.5 * run.velocity(ball).squaredNorm() + 0.5 * inertia * run.state(ball).angular_velocity.squaredNorm() +
         g * (run.position(ball).z() - 0.5 * run.h() * run.velocity(ball).z());
}

}  // namespace

// Without friction the part of the velocity that points into the face is lost, sin^2 a of the energy. A ball that rolls keeps its
// angular momentum about the new point of contact: v becomes v (2 + 5 cos a) / 7. Wherever in its step it comes to the edge, what
// else is lost is of second order in the step, by (g h sin a / v)^2; it was up to twice the root of that.
TEST_P(EdgeCrossing, TakesWhatTheImpactTakes) {
  const auto [solver, substeps] = GetParam();
  for (const Ground kind : {Ground::boxes, Ground::compound, Ground::field})
    for (const double angle : {0.065, 0.13})
      for (const bool rolls : {false, true})
        for (int phase = 0; phase < 16; ++phase) {
          const double v = 0.3, h = 0.016 / substeps, start = -(8.3 + phase / 16.0) * v * h - radius * std::tan(angle / 2);
          std::ostringstream text;
          text.precision(17);
          text << "time: {substeps: " << substeps << "}\nsolver: {name: " << solver
               << "}\nmaterials: {m: {friction: " << (rolls ? 1 : 0) << "}}\nbodies:\n"
               << ground_of(kind, angle) << "  - {shape: {sphere: {radius: 0.1}}, mass: 1, position: [" << start
               << ", 0.013, 0.1], velocity: [0.3, 0, 0], angular_velocity: [0, " << (rolls ? v / radius : 0) << ", 0]}\n";
          Experiment run(scene_from_text(text.str()));
          const Id ball = kind == Ground::boxes ? 2 : 1;
          const double inertia = 0.4 * radius * radius, kept = rolls ? (2 + 5 * std::cos(angle)) / 7 : std::cos(angle);
          const double before = energy(run, ball, inertia) - g * radius;
          run.steps(14);
          const double after = energy(run, ball, inertia) - g * radius, slope = g * h * std::sin(angle) / v;
          EXPECT_GT(run.position(ball).x(), 3 * v * h - radius * std::tan(angle / 2))
              << static_cast<int>(kind) << ", " << angle << ": the edge is not behind it";
          EXPECT_NEAR(after / before, kept * kept, slope * slope + 1e-4)
              << static_cast<int>(kind) << ", angle " << angle << (rolls ? ", rolls" : ", slides") << ", phase " << phase;
        }
}

INSTANTIATE_TEST_SUITE_P(, EdgeCrossing,
                         testing::Combine(testing::Values("accelerated_jacobi", "gauss_seidel"), testing::Values(1, 4)));

}  // namespace unibody::small_worlds::edge_crossing_test
