// Which acceleration a scene gets where its settings leave it open.
#include <gtest/gtest.h>

#include <string>

#include "report/state_hash.hpp"
#include "small_worlds.hpp"

namespace unibody::small_worlds::acceleration_test {

namespace {

// After 20 steps, in the last of which things touch.
std::uint64_t state_with(const std::string& scene, const std::string& acceleration, const std::string& more) {
  Experiment run(scene_from_text(scene + "solver: {iterations: 10, tolerance: 0, acceleration: " + acceleration + more + "}\n"));
  run.steps(20);
  EXPECT_FALSE(run.simulation->contacts.points.empty() && run.simulation->contacts.surface.empty());
  return state_hash(MPI_COMM_SELF, run.world());
}

enum class Is { optimized, nesterov };

void expect_automatic(const std::string& scene, Is expected, const std::string& more = "") {
  const auto found = state_with(scene, "auto", more);
  const auto optimized = state_with(scene, "optimized", more), nesterov = state_with(scene, "nesterov", more);
  EXPECT_NE(optimized, nesterov) << scene << more;
  EXPECT_EQ(found, expected == Is::optimized ? optimized : nesterov) << scene << more;
}

const std::string box = "shape: {box: {size: [0.3, 0.3, 0.3]}}, mass: 1, orientation: {axis: [0.6, 0.8, 0], angle: 5}";
const std::string boxes = "bodies:\n  - {shape: {plane: {normal: [0, 0, 1]}}}\n  - {name: lower, " + box +
                          ", position: [0, 0, 0.2]}\n  - {name: upper, " + box + ", position: [0.05, 0, 0.55]}\n";

const std::string light_cloth =
    "cloths:\n  - grid: {size: [1, 1], nodes: [6, 6]}\n    mass: 1\n    thickness: 0.01\n    position: [0, 0, 0.9]\n"
    "    links: {}\n";

}  // namespace

TEST(Acceleration, IsOptimizedWhereRowsBearIt) {
  expect_automatic(boxes, Is::optimized);
  expect_automatic(boxes, Is::optimized, ", stages: together");
  expect_automatic(boxes, Is::optimized, ", stages: position");
  expect_automatic(boxes, Is::optimized, ", level: velocity");
  expect_automatic(boxes + light_cloth, Is::optimized);
}

TEST(Acceleration, IsNesterovsWhereRowsTurnOrTheirBoundIsPassed) {
  expect_automatic(boxes, Is::nesterov, ", gap: reevaluated, stages: position");
  expect_automatic(boxes, Is::nesterov, ", scaling: 0.9");
  // Only the stages of steps in which something bounces in the solve, as nodes do; what bodies do is resolved before it.
  const std::string wood = "materials: {wood: {friction: 0.3, restitution: 0.5}}\n";
  expect_automatic(wood + boxes, Is::optimized);
  const std::string bouncing = wood + boxes + light_cloth;
  EXPECT_NE(state_with(bouncing, "auto", ""), state_with(bouncing, "optimized", ""));
  EXPECT_NE(state_with(bouncing, "auto", ""), state_with(bouncing, "nesterov", ""));
  expect_automatic(boxes + "joints:\n  - {type: ball, bodies: [upper, lower], anchor: [0, 0, 0.375]}\n", Is::nesterov);
  expect_automatic(boxes + light_cloth, Is::nesterov, ", level: velocity");
  expect_automatic(boxes + light_cloth + "    bending: {model: dihedral, stiffness: 0.01}\n", Is::nesterov, ", stages: position");
}

}  // namespace unibody::small_worlds::acceleration_test
