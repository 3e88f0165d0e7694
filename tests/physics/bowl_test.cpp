// A ball that slides in a bowl of triangles goes over their edges and nodes as over the faces they join.
#include <gtest/gtest.h>

#include <cmath>
#include <sstream>

#include "small_worlds.hpp"

namespace unibody::small_worlds::bowl_test {

namespace {

constexpr double radius = 1, ball = 0.1, g = 9.81, reach = 1.2;  // m, m, m/s^2, rad: of the bowl, from its bottom

// A ball without friction at rest on the bowl of `rings` rings of triangles, 0.2 rad up.
std::string in_bowl(int rings, double azimuth, const std::string& solver, int substeps) {
  std::ostringstream text;
  text << "time: {substeps: " << substeps << "}\nsolver: {name: " << solver << "}\nmaterials: {m: {friction: 0}}\nbodies:\n"
       << "  - {shape: {mesh: {revolve: {profile: [[0, -1]";
  for (int k = 1; k <= rings; ++k)
    text << ", [" << radius * std::sin(reach * k / rings) << ", " << -radius * std::cos(reach * k / rings) << "]";
  const double away = (radius - ball) * std::sin(0.2), low = (radius - ball) * std::cos(0.2) - 1e-4;
  text << "], sides: " << 2 * rings << "}, sides: both}}}\n  - {shape: {sphere: {radius: 0.1}}, mass: 1, position: ["
       << away * std::cos(azimuth) << ", " << away * std::sin(azimuth) << ", " << -low << "]}\n";
  return text.str();
}

class Bowl : public testing::TestWithParam<std::tuple<const char*, int>> {};

}  // namespace

// At an edge of the angle a the ball may lose the part of its speed v that points into the next face, of the energy at most
// (v a)^2 a unit of mass, and its weight may act for a step as if it were on that face already, which takes up to g h v a. No
// step takes more for the edges that it passes; nodes ahead of the ball took a fifth of its energy at once.
TEST_P(Bowl, NoNodeAheadBrakesABall) {
  const auto [solver, substeps] = GetParam();
  for (const int rings : {40, 160})
    for (const double azimuth : {0.0, 0.3, 1.1}) {
      Experiment run(scene_from_text(in_bowl(rings, azimuth, solver, substeps)));
      const double h = run.h(), angle = reach / rings, edge = radius * angle;
      const auto energy = [&] {  // at the middle of the step, which keeps it where a body falls or slides down a plane
        return 0.5 * run.velocity(1).squaredNorm() + g * (run.position(1).z() - 0.5 * h * run.velocity(1).z());
      };
      run.steps(10 * substeps);  // it settles on the faces
      double turned = 0, before = energy();
      for (int k = 0; k < 180 * substeps; ++k) {
        const double speed = run.velocity(1).norm(), x = run.position(1).head<2>().norm();
        run.step();
        const double passed = 2 + h * speed / edge;
        EXPECT_GT(energy() - before, -passed * angle * (speed * speed * angle + g * h * speed) - 1e-5)
            << rings << " rings, step " << k << ", " << speed << " m/s";
        before = energy(), turned = std::max(turned, std::abs(x));
      }
      EXPECT_GT(turned, 0.15);
    }
}

// A ball that goes round in a pipe of 64 sides comes to several of them in a step, and stays in it. Each edge takes the part of
// the velocity that points into the next side: after n of them v cos^n a is left, as steps that pass less than an edge find.
TEST_P(Bowl, ABallThatCirclesInAPipeStaysInIt) {
  const auto [solver, substeps] = GetParam();
  for (const double speed : {0.5, 2.0, 5.0, 20.0})
    for (const double ball : {0.01, 0.05}) {
      const double angle = 2 * M_PI / 64, apothem = 0.5 * std::cos(angle / 2), away = apothem - ball;
      std::ostringstream text;
      text.precision(17);
      text << "gravity: [0, 0, 0]\ntime: {substeps: " << substeps << "}\nsolver: {name: " << solver
           << "}\nmaterials: {m: {friction: 0}}\nbodies:\n"
           << "  - {shape: {mesh: {revolve: {profile: [[0.5, -1], [0.5, 1]], sides: 64}, sides: both}}}\n  - {shape: {sphere: "
              "{radius: "
           << ball << "}}, mass: 1, position: [" << away * std::cos(angle / 2) << ", " << away * std::sin(angle / 2)
           << ", 0], velocity: [" << -speed * std::sin(angle / 2) << ", " << speed * std::cos(angle / 2) << ", 0]}\n";
      Experiment run(scene_from_text(text.str()));
      double turned = 0;
      for (int k = 0; k < 100 * substeps; ++k) {
        const Vec3 before = run.position(1);
        run.step();
        const Vec3 now = run.position(1);
        turned += std::atan2(before.x() * now.y() - before.y() * now.x(), before.head<2>().dot(now.head<2>()));
        ASSERT_LT(now.head<2>().norm(), 0.5 - 0.5 * ball) << speed << " m/s, ball of " << ball << " m, step " << k;
      }
      if (speed * run.h() > 0.021) continue;  // half an edge
      const double edges = turned / angle;
      EXPECT_NEAR(run.velocity(1).norm() / speed, std::pow(std::cos(angle), edges), 0.5 * angle * angle + 1e-3)
          << speed << " m/s, ball of " << ball << " m, " << edges << " edges";
    }
}

INSTANTIATE_TEST_SUITE_P(, Bowl, testing::Combine(testing::Values("accelerated_jacobi", "gauss_seidel"), testing::Values(1, 4)));

}  // namespace unibody::small_worlds::bowl_test
