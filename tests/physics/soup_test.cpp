// Surfaces of triangles as files bring them: bodies lie on them and stay on the side that they come from, whatever the file's
// faults.
#include <gtest/gtest.h>

#include <cmath>

#include "scene/scene_text.hpp"
#include "small_worlds.hpp"
#include "world/shape_library.hpp"

namespace unibody::small_worlds::soup_test {

namespace {

// A square of 4 m at height 0 whose two halves meet in the diagonal x = y; nodes 5 and 6 stand over and under its middle.
const std::string corners = "v -2 -2 0\nv 2 -2 0\nv 2 2 0\nv -2 2 0\nv 0 0 1\nv 0 0 -1\nv 0 0 0\nv 1 0 0\nv 2 0 0\n";
const std::string apart = "v -2 -2 0\nv 2 -2 0\nv 2 2 0\nv -2 -2 0\nv 2 2 0\nv -2 2 0\n";

struct Soup {
  std::string name, text;
  bool both_sides = false;  // the file does not say which side is out
  bool wall = false;        // over the diagonal
  bool is_free(double up) const { return !wall && (up > 0 || text.find("f 1 3 6") == std::string::npos); }  // of walls
};

const Soup soups[] = {
    {"sound", corners + "f 1 2 3\nf 1 3 4\n"},
    {"three at an edge, one of them under it", corners + "f 1 2 3\nf 1 3 4\nf 1 3 6\n"},
    {"three at an edge, one of them on it", corners + "f 1 2 3\nf 1 3 4\nf 1 3 5\n", false, true},
    {"four at an edge", corners + "f 1 3 6\nf 1 2 3\nf 1 3 4\nf 1 3 5\n", false, true},
    {"given twice", corners + "f 1 2 3\nf 1 2 3\nf 3 4 1\nf 1 3 4\n"},
    {"given both ways", corners + "f 1 2 3\nf 1 3 4\nf 1 3 2\nf 1 4 3\n", true},
    {"wound against each other", corners + "f 1 2 3\nf 1 4 3\n", true},
    {"wound against each other, three at an edge", corners + "f 1 2 3\nf 1 4 3\nf 1 3 6\n", true},
    {"without area", corners + "f 7 8 9\nf 1 2 3\nf 1 3 4\nf 1 1 2\nf 1 7 3\n"},
    {"apart", apart + "f 1 2 3\nf 4 5 6\n"},
    {"apart and wound against each other", apart + "f 1 2 3\nf 4 6 5\n", true},
    {"all faults", corners + "f 7 8 9\nf 1 4 3\nf 1 2 3\nf 3 2 1\nf 1 3 6\nf 2 2 2\n", true},
};

// Balls and boxes of 0.1 m to either side of the diagonal, and across it.
std::string bodies_at(double z, const std::string& more, bool across) {
  const auto body = [&](const std::string& shape, double x, double y) {
    return "  - {shape: {" + shape + "}, mass: 1, position: [" + std::to_string(x) + ", " + std::to_string(y) + ", " +
           std::to_string(z) + "]" + more + "}\n";
  };
  const std::string sphere = "sphere: {radius: 0.1}", box = "box: {size: [0.2, 0.2, 0.2]}";
  std::string text = body(sphere, 1, -0.5) + body(sphere, -0.5, 1) + body(box, 1.2, 0.3) + body(box, -1.1, 0.4);
  if (across) text += body(sphere, 0.7, 0.7) + body(box, -0.7, -0.7) + body(box, -1.18, -1.22);
  return text;
}

Scene scene_on(const TextFile& soup, const std::string& more) {
  return scene_from_text("bodies:\n  - {shape: {mesh: {file: " + soup.path() + "}}}\n" + more +
                         "solver: {name: gauss_seidel, iterations: 50, tolerance: 0}\n");
}

}  // namespace

TEST(Soup, BodiesComeToRestOnIt) {
  for (const Soup& soup : soups) {
    const TextFile file(soup.text, ".obj");
    for (const double up : {1.0, -1.0}) {
      if (up < 0 && !soup.both_sides) continue;
      Scene scene = scene_on(file, bodies_at(0.2 * up, "", soup.is_free(up)));
      scene.gravity *= up;
      Experiment run(std::move(scene));
      run.seconds(1.5);
      for (Id k = 1; k < run.scene->body_count(); ++k) {
        EXPECT_NEAR(run.position(k).z(), 0.1 * up, 2e-5) << soup.name << ", body " << k;
        EXPECT_LT(run.velocity(k).norm(), 1e-6) << soup.name << ", body " << k;
      }
    }
  }
}

// 0.5 m in a step.
TEST(Soup, FastBodiesStayOnTheirSide) {
  for (const Soup& soup : soups) {
    const TextFile file(soup.text, ".obj");
    for (const double up : {1.0, -1.0}) {
      if (up < 0 && !soup.both_sides) continue;
      Scene scene = scene_on(file, bodies_at(0.8 * up, ", velocity: [0, 0, " + std::to_string(-30 * up) + "]", soup.is_free(up)));
      scene.gravity *= up;
      Experiment run(std::move(scene));
      run.seconds(1);
      for (Id k = 1; k < run.scene->body_count(); ++k) EXPECT_NEAR(run.position(k).z() * up, 0.1, 1e-3) << soup.name << ' ' << k;
    }
  }
}

// Over a flat edge, and whatever hangs under it, a ball rolls as on a plane.
TEST(Soup, ABallRollsOverItsEdges) {
  for (const Soup& soup : soups) {
    if (soup.wall) continue;
    const TextFile file(soup.text, ".obj");
    Experiment run(scene_on(file,
                            "  - {shape: {sphere: {radius: 0.1}}, mass: 1, position: [-0.5, 0.1, 0.1], velocity: [1, 0, 0], "
                            "angular_velocity: [0, 10, 0]}\n"));
    for (int k = 0; k < 75; ++k) {
      run.step();
      ASSERT_NEAR(run.position(1).z(), 0.1, 1e-6) << soup.name << ' ' << k;
      ASSERT_LT((run.velocity(1) - Vec3(1, 0, 0)).norm(), 1e-6) << soup.name << ' ' << k;
    }
  }
}

// The triangle over the diagonal, from the side to which it turns: with the ground it makes a corner that holds a ball.
TEST(Soup, AWallOnAnEdgeHolds) {
  for (const Soup& soup : soups) {
    if (!soup.wall) continue;
    const TextFile file(soup.text, ".obj");
    Scene scene = scene_on(file, "  - {shape: {sphere: {radius: 0.1}}, mass: 1, position: [0.5, -0.5, 0.3]}\n");
    scene.gravity = Vec3(-5, 5, -9.81);
    Experiment run(std::move(scene));
    run.seconds(2);
    const Vec3 x = run.position(1);
    EXPECT_NEAR((x.x() - x.y()) / std::sqrt(2.0), 0.1, 2e-5) << soup.name;
    EXPECT_NEAR(x.z(), 0.1, 2e-5) << soup.name;
  }
}

// A body that overhangs an edge of a two-sided plate is held by its top alone: the side wall, in front of whose back it would be,
// belongs to the same side.
TEST(Soup, ATableOfTwoSidesHoldsABoxOverItsEdge) {
  const TextFile file(
      "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nv -1 -1 -1\nv 1 -1 -1\nv 1 1 -1\nv -1 1 -1\n"
      "f 1 2 3\nf 1 4 3\nf 1 2 6\nf 1 6 5\nf 2 3 7\nf 2 6 7\nf 3 4 8\nf 3 8 7\nf 4 1 5\nf 4 5 8\n",
      ".obj");
  Experiment run(scene_on(file,
                          "  - {shape: {box: {size: [0.4, 0.2, 0.2]}}, mass: 1, position: [0.9, 0.2, 0.11]}\n"
                          "  - {shape: {sphere: {radius: 0.1}}, mass: 1, position: [0.3, 0.3, -0.5]}\n"));
  run.seconds(1.5);
  EXPECT_LT((run.position(1) - Vec3(0.9, 0.2, 0.1)).norm(), 1e-3);
  EXPECT_NEAR(run.position(1).z(), 0.1, 2e-5);
  EXPECT_LT(run.position(2).z(), -2) << "open below: what is inside falls out";
}

TEST(Soup, SaysWhatItLeftOut) {
  const auto note = [](const Soup& soup) {
    const TextFile file(soup.text, ".obj");
    const Scene scene = scene_on(file, "");
    const std::string text = scene.notes.empty() ? "" : scene.notes[0];
    return text.starts_with(file.path() + ": ") ? text.substr(file.path().size() + 2) : text;
  };
  const std::string both = "its triangles do not agree which side is out: touched from both";
  EXPECT_EQ(note(soups[0]), "");
  EXPECT_EQ(note(soups[2]), "");
  EXPECT_EQ(note(soups[4]), "left out 2 triangles given before");
  EXPECT_EQ(note(soups[6]), both);
  EXPECT_EQ(note(soups[8]), "left out 3 triangles without area");
  EXPECT_EQ(note(soups[11]), "left out 2 triangles without area and 1 triangle given before; " + both);
}

// Neighbours agree in every patch, and where they cannot, on a Moebius strip, it is cut.
TEST(Soup, PatchesAgree) {
  constexpr int n = 12;
  std::vector<Vec3> nodes;
  std::vector<std::array<std::int32_t, 3>> triangles;
  for (int k = 0; k < n; ++k)
    for (const double side : {-0.3, 0.3}) {
      const double a = 2 * M_PI * k / n;
      const double r = 1 + side * std::cos(a / 2);
      nodes.emplace_back(r * std::cos(a), r * std::sin(a), side * std::sin(a / 2));
    }
  for (int k = 0; k < n; ++k) {
    const bool last = k == n - 1;
    const int a = 2 * k, b = a + 1, c = last ? 1 : a + 2, d = last ? 0 : a + 3;
    triangles.push_back({a, b, d}), triangles.push_back({a, d, c});
  }
  std::swap(triangles[5][0], triangles[5][1]);
  const MeshSurface mesh = make_mesh_shape(nodes, triangles);
  EXPECT_TRUE(mesh.two_sided);
  int joined = 0, cut = 0;
  for (const auto& t : mesh.triangles)
    for (std::size_t k = 0; k < 3; ++k)
      for (const auto& other : mesh.triangles)
        for (std::size_t j = 0; j < 3 && &other != &t; ++j) {
          const std::int32_t p = t.nodes[k], q = t.nodes[(k + 1) % 3], r = other.nodes[j], s = other.nodes[(j + 1) % 3];
          if (std::minmax(p, q) != std::minmax(r, s)) continue;
          const bool agree = p == s;
          EXPECT_EQ(t.across[k] >= 0, agree);
          EXPECT_TRUE(!agree || t.across[k] == other.nodes[(j + 2) % 3]);
          ++(agree ? joined : cut);
        }
  EXPECT_EQ(cut, 2);
  EXPECT_EQ(joined, 2 * (2 * n - 1));
}

}  // namespace unibody::small_worlds::soup_test
