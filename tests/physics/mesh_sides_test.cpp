// Which side of a mesh shape is touched: closed ones are solids or containers by where bodies start, open ones have two sides.
#include "step/mesh_sides.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "scene/scene_text.hpp"
#include "small_worlds.hpp"

namespace unibody::small_worlds::mesh_sides_test {

namespace {

// A box of edge 1 m whose faces turn outwards, or inwards.
std::string box_surface(bool outwards) {
  std::string text;
  for (int k = 0; k < 8; ++k)
    text += "v " + std::string(k & 4 ? "0.5 " : "-0.5 ") + (k & 2 ? "0.5 " : "-0.5 ") + (k & 1 ? "0.5\n" : "-0.5\n");
  const int faces[12][3] = {{1, 2, 4}, {1, 4, 3}, {5, 7, 8}, {5, 8, 6}, {1, 5, 6}, {1, 6, 2},
                            {3, 4, 8}, {3, 8, 7}, {1, 3, 7}, {1, 7, 5}, {2, 6, 8}, {2, 8, 4}};
  for (const auto& f : faces)
    text += "f " + std::to_string(f[0]) + " " + std::to_string(f[outwards ? 1 : 2]) + " " + std::to_string(f[outwards ? 2 : 1]) +
            "\n";
  return text;
}

const std::string inside =
    "  - {shape: {sphere: {radius: 0.05}}, density: 2500, lattice: {count: 20, columns: [5, 4], spacing: [0.15, 0.15, 0.15], "
    "height: "
    "-0.1}}\n";
const std::string above = "  - {shape: {sphere: {radius: 0.05}}, density: 2500, points: [[0, 0, 0.7], [0.2, 0.1, 0.8]]}\n";

struct Started {
  Experiment run;
  std::vector<std::string> notes;
};

Started started(const TextFile& surface, const std::string& bodies, const std::string& sides = "") {
  Scene scene = scene_from_text("bodies:\n  - {shape: {mesh: {file: " + surface.path() + sides + "}}}\n" + bodies);
  std::vector<std::string> notes;
  decide_mesh_sides(MPI_COMM_SELF, scene, notes);
  return {Experiment(std::move(scene)), notes};
}

}  // namespace

TEST(MeshSides, AClosedSurfaceHoldsWhatStartsInside) {
  for (const bool outwards : {true, false}) {
    const TextFile surface(box_surface(outwards), ".obj");
    Started s = started(surface, inside);
    EXPECT_EQ(s.notes.size(), outwards ? 1u : 0u);  // said where it was turned over
    s.run.seconds(1.5);
    for (Id id = 1; id <= 20; ++id) EXPECT_LT(s.run.position(id).cwiseAbs().maxCoeff(), 0.4501) << id << ' ' << outwards;
  }
}

TEST(MeshSides, AClosedSurfaceCarriesWhatStartsOutside) {
  for (const bool outwards : {true, false}) {
    const TextFile surface(box_surface(outwards), ".obj");
    Started s = started(surface, above);
    s.run.seconds(1);
    for (Id id = 1; id <= 2; ++id) EXPECT_NEAR(s.run.position(id).z(), 0.55, 1e-3) << id << ' ' << outwards;
  }
}

TEST(MeshSides, AndBothAtOnce) {
  for (const bool outwards : {true, false}) {
    const TextFile surface(box_surface(outwards), ".obj");
    Started s = started(surface, inside + above);
    ASSERT_EQ(s.notes.size(), 1u);
    EXPECT_NE(s.notes[0].find("both"), std::string::npos);
    s.run.seconds(1);
    for (Id id = 1; id <= 20; ++id) EXPECT_LT(s.run.position(id).cwiseAbs().maxCoeff(), 0.4501) << id;
    for (Id id = 21; id <= 22; ++id) EXPECT_NEAR(s.run.position(id).z(), 0.55, 1e-3) << id;
  }
}

TEST(MeshSides, WhatIsSaidHolds) {
  const TextFile surface(box_surface(true), ".obj");
  Started s = started(surface, inside, ", sides: back");
  EXPECT_TRUE(s.notes.empty());
  s.run.seconds(1);
  EXPECT_LT(s.run.position(1).cwiseAbs().maxCoeff(), 0.4501);
  EXPECT_NE(
      fault_of("bodies:\n  - {shape: {mesh: {file: " + surface.path() + ", sides: in}}}\n").find("auto, front, back or both"),
      std::string::npos);
  const TextFile against("v -2 -2 0\nv 2 -2 0\nv 2 2 0\nv -2 2 0\nf 1 2 3\nf 1 4 3\n", ".obj");
  EXPECT_NE(fault_of("bodies:\n  - {shape: {mesh: {file: " + against.path() + ", sides: front}}}\n").find("do not agree"),
            std::string::npos);
}

// A plate of two triangles, shot at from both sides: a ball and a box of 1 cm at 20 m/s, 32 times their size in a step.
TEST(MeshSides, AnOpenSurfaceHoldsOnBoth) {
  const TextFile plate("v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nf 1 2 3\nf 1 3 4\n", ".obj");
  for (const double side : {1.0, -1.0})
    for (const double height : {0.01, 0.17, 0.3})
      for (const int substeps : {1, 4}) {
        const auto place = [&](double x, double y) {
          return "position: [" + std::to_string(x) + ", " + std::to_string(y) + ", " + std::to_string(side * height) +
                 "], velocity: [0, 0, " + std::to_string(-20 * side) + "]";
        };
        Scene scene = scene_from_text("time: {substeps: " + std::to_string(substeps) + "}\ngravity: [0, 0, " +
                                      std::to_string(-9.81 * side) + "]\nbodies:\n  - {shape: {mesh: {file: " + plate.path() +
                                      "}}}\n  - {shape: {sphere: {radius: 0.005}}, mass: 1, " + place(0.1, 0.2) +
                                      "}\n  - {shape: {box: {size: [0.01, 0.01, 0.01]}}, mass: 1, " + place(-0.3, -0.3) +
                                      ", angular_velocity: [3, 8, 2]}\n");
        Experiment run(std::move(scene));
        run.seconds(0.16);
        for (Id id = 1; id <= 2; ++id) EXPECT_GT(side * run.position(id).z(), 0.0049) << id << ' ' << side << ' ' << height;
        EXPECT_NEAR(side * run.position(1).z(), 0.005, 1e-4) << side << ' ' << height;
      }
}

}  // namespace unibody::small_worlds::mesh_sides_test
