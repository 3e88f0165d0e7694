// Fast bodies of any shape stay in pipes and boxes of triangles.
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <sstream>

#include "small_worlds.hpp"
#include "world/shape_library.hpp"

namespace unibody::small_worlds::pipe_test {

namespace {

// All of them fit into a ball of 0.05 m, and a ball of 0.02 m about the centre fits into each, but for the compound's.
const std::map<std::string, std::string> shapes{
    {"ball", "sphere: {radius: 0.03}"},
    {"box", "box: {size: [0.05, 0.05, 0.05]}"},
    {"capsule", "capsule: {radius: 0.03, length: 0.03}"},
    {"cylinder", "cylinder: {radius: 0.03, length: 0.06}"},
    {"octahedron", "hull: {points: [[0.05, 0, 0], [-0.05, 0, 0], [0, 0.05, 0], [0, -0.05, 0], [0, 0, 0.05], [0, 0, -0.05]]}"},
    {"compound",
     "compound: {parts: [{shape: {sphere: {radius: 0.03}}, position: [0, 0, 0.02]}, "
     "{shape: {sphere: {radius: 0.03}}, position: [0, 0, -0.02]}]}"}};

// m, in the body's axes: of a compound's parts.
std::vector<Vec3> centres(const Shape& shape) {
  if (shape.kind != ShapeKind::compound) return {Vec3::Zero()};
  std::vector<Vec3> places;
  for (const Compound::Part& part : shape_library().compounds[shape.data].parts) places.push_back(part.place);
  return places;
}

struct Case {
  const char* solver;
  int substeps;
};

std::ostream& operator<<(std::ostream& out, const Case& c) { return out << c.solver << ", " << c.substeps << " substeps"; }

class Pipe : public testing::TestWithParam<Case> {};

}  // namespace

// In a pipe of 64 sides that stands or turns about its axis, bodies go round at 2 to 10 m/s, and pass up to four sides in a step.
// Contacts alone keep them in it: no body's centre comes nearer to the wall than 0.015 m.
TEST_P(Pipe, BodiesOfAnyShapeStayInIt) {
  const auto [solver, substeps] = GetParam();
  for (const double turn : {0.0, 3.0, -6.0})
    for (const double speed : {2.0, 5.0, 10.0})
      for (const auto& [name, shape] : shapes) {
        const double half = M_PI / 64, apothem = 0.5 * std::cos(half), away = apothem - 0.051;
        std::ostringstream text;
        text.precision(17);
        text << "gravity: [0, 0, 0]\ntime: {substeps: " << substeps << "}\nsolver: {name: " << solver
             << "}\nmaterials: {m: {friction: 0}}\nbodies:\n"
             << "  - {shape: {mesh: {revolve: {profile: [[0.5, -1], [0.5, 1]], sides: 64}, sides: both}}, motion: kinematic, "
                "angular_velocity: [0, 0, "
             << turn << "]}\n  - {shape: {" << shape << "}, mass: 1, position: [" << away * std::cos(half) << ", "
             << away * std::sin(half) << ", 0], velocity: [" << -speed * std::sin(half) << ", " << speed * std::cos(half)
             << ", 0]}\n";
        Experiment run(scene_from_text(text.str()));
        for (int k = 0; k < 60 * substeps; ++k) {
          run.step();
          ASSERT_LT(run.position(1).head<2>().norm(), apothem - 0.015) << name << ", " << speed << " m/s, turn " << turn;
          EXPECT_EQ(run.last.held_bodies, 0) << name << ", " << speed << " m/s, turn " << turn << ", step " << k;
        }
      }
}

// Thrown at 20 m/s into the walls and corners of a box, 1 m wide, with walls of triangles or of six plates 1 cm thick, bodies are
// turned aside to the next wall and start to spin so fast that contacts of the step's start tell nothing of its end. No part's
// centre leaves the box all the same.
TEST_P(Pipe, NothingIsThrownOutOfABox) {
  const auto [solver, substeps] = GetParam();
  const std::string sides =
      "{shape: {box: {size: [0.01, 1.2, 1.2]}}, position: [0.505, 0, 0]}, {shape: {box: {size: [0.01, 1.2, 1.2]}}, position: "
      "[-0.505, "
      "0, 0]}, {shape: {box: {size: [1.2, 0.01, 1.2]}}, position: [0, 0.505, 0]}, {shape: {box: {size: [1.2, 0.01, 1.2]}}, "
      "position: "
      "[0, -0.505, 0]}, {shape: {box: {size: [1.2, 1.2, 0.01]}}, position: [0, 0, 0.505]}, {shape: {box: {size: [1.2, 1.2, "
      "0.01]}}, "
      "position: [0, 0, -0.505]}";
  const std::string of_triangles =
      "{mesh: {revolve: {profile: [[0, -0.5], [0.70710678118654757, -0.5], [0.70710678118654757, 0.5], [0, 0.5]], sides: 4}, "
      "sides: "
      "both}}";
  const std::string walls[] = {
      "  - {name: box, shape: " + of_triangles + ", motion: fixed, orientation: {axis: [0, 0, 1], angle: 45}}\n",
      "  - {name: box, shape: {compound: {parts: [" + sides + "]}}, motion: fixed}\n"};
  for (const std::string& box : walls) {
    std::int64_t held = 0;
    for (const double restitution : {0.0, 1.0}) {
      std::ostringstream text;
      text << "time: {substeps: " << substeps << "}\nsolver: {name: " << solver
           << "}\nmaterials: {m: {friction: 0, restitution: " << restitution << "}}\nbodies:\n"
           << box;
      int bodies = 0;
      for (const auto& [name, shape] : shapes)
        for (int k = 0; k < 40; ++k, ++bodies) {
          const double azimuth = 0.37 + 2.4 * bodies, up = std::sin(1.7 * bodies), out = std::sqrt(1 - up * up);
          text << "  - {shape: {" << shape << "}, mass: 1, collide: {with: [box]}, orientation: [0.8, 0.2, 0.4, 0.4], velocity: ["
               << 20 * out * std::cos(azimuth) << ", " << 20 * out * std::sin(azimuth) << ", " << 20 * up << "]}\n";
        }
      Experiment run(scene_from_text(text.str()));
      for (int k = 0; k < 60 * substeps; ++k) {
        run.step();
        held += run.last.held_bodies;
        for (Id id = 1; id <= bodies; ++id) {
          const BodyState body = run.state(id);
          for (const Vec3& place : centres(run.world().properties[run.slot(id)].shape))
            ASSERT_LT((body.position + body.orientation * place).cwiseAbs().maxCoeff(), 0.5) << "body " << id << ", step " << k;
        }
      }
    }
    EXPECT_TRUE(held > 0 || substeps > 1);
  }
}

INSTANTIATE_TEST_SUITE_P(, Pipe,
                         testing::Values(Case{"accelerated_jacobi", 1}, Case{"accelerated_jacobi", 4}, Case{"gauss_seidel", 1},
                                         Case{"gauss_seidel", 4}));

}  // namespace unibody::small_worlds::pipe_test
