// Cloths over held boxes, where edges lie on edges, and a cloth in the place of another.
#include <gtest/gtest.h>

#include <cmath>

#include "report/surface_report.hpp"
#include "small_worlds.hpp"

namespace unibody::small_worlds::cloth_on_edge_test {

namespace {

const Vec3 place(0, 0, 0.3);  // m, of the box

// A sheet of 1 m falls 2 cm onto a box over the ground and hangs down around it.
Experiment draped(const Vec3& size, int nodes, const std::string& links) {
  std::ostringstream text;
  text << "bodies:\n  - {shape: {box: {size: [" << size.x() << ", " << size.y() << ", " << size.z()
       << "]}}, motion: fixed, position: [0, 0, 0.3]}\n  - {shape: {plane: {normal: [0, 0, 1]}}}\n"
       << "cloths:\n  - {grid: {size: [1, 1], nodes: [" << nodes << ", " << nodes
       << "]}, mass: 0.3, thickness: 0.01, self_collision: true, links: " << links << ", position: [0, 0, 0.47]}\n";
  return Experiment(scene_from_text(text.str()));
}

// m, how deep a point of the line between two points is in the box: the largest of closely spaced ones; negative: outside.
double depth(const Vec3& half, const Vec3& from, const Vec3& to) {
  double deepest = -HUGE_VAL;
  for (int k = 0; k <= 40; ++k)
    deepest = std::max(deepest, (half - (from + k / 40.0 * (to - from) - place).cwiseAbs()).minCoeff());
  return deepest;
}

// m, of all edges of the cloth, whose middle surface is half its thickness off its sides.
double deepest_edge(Experiment& run, const Vec3& half) {
  run.simulation->detect();
  double deepest = -HUGE_VAL;
  for (const SurfaceEdge& edge : run.simulation->search.surfaces.edges) {
    const auto at = [&](std::size_t k) { return run.world().position[static_cast<std::size_t>(edge.nodes[k])]; };
    deepest = std::max(deepest, depth(half, at(0), at(1)));
  }
  return deepest;
}

}  // namespace

// At rest with the default solver, whose iterations leave links stretched by percents: none of the cloth's edges is in the box,
// though stiff links pull them in. A blade of 1 mm, less than the cloth is thick, cuts through none either.
TEST(ClothOnEdge, LinksDoNotPullAClothIntoABox) {
  struct Case {
    Vec3 size;
    int nodes;
    const char* links;
  };
  for (const Case& c : {Case{{0.3, 0.3, 0.3}, 31, "{}"}, {{0.001, 0.3, 0.3}, 21, "{stiffness: 1000}"}}) {
    Experiment run = draped(c.size, c.nodes, c.links);
    run.steps(60);
    for (int k = 0; k < 4; ++k) {
      run.steps(10);
      EXPECT_LT(deepest_edge(run, c.size / 2), 0) << c.size.x() << ", step " << 70 + 10 * k;
    }
  }
}

// Two sheets that are one to the last bit, level, on edge or the one turned upside down: they part to where they touch, and
// nothing goes through anything. No rule could say which is above; both stay level.
TEST(ClothOnEdge, TwoInOnePlacePart) {
  for (const char* turn : {"{axis: [0, 0, 1], angle: 0}", "{axis: [1, 0, 0], angle: 90}", "{axis: [0.6, 0, 0.8], angle: 70}"}) {
    const std::string sheet =
        "  - {grid: {size: [1, 1], nodes: [9, 9]}, mass: 1, thickness: 0.02, orientation: " + std::string(turn) + "}\n";
    Experiment run(scene_from_text("gravity: [0, 0, 0]\ncloths:\n" + sheet + sheet));
    run.step();
    EXPECT_GT((run.position(40) - run.position(40 + 81)).norm(), 1e-4) << turn;
    run.steps(60);
    run.simulation->detect();
    EXPECT_EQ(count_crossings(MPI_COMM_SELF, run.world(), run.simulation->search.surfaces), 0) << turn;
    const Vec3 apart = run.position(40) - run.position(40 + 81);
    EXPECT_GE(apart.norm(), 0.02 - 1e-4) << turn;
    for (Id k = 0; k < 81; ++k) EXPECT_LT((run.position(k) - run.position(k + 81) - apart).norm(), 1e-3) << turn << ' ' << k;
  }
}

}  // namespace unibody::small_worlds::cloth_on_edge_test
