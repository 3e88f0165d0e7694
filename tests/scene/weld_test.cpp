// Welding: nodes at one place become one, in a time that grows with their number; what is one sheet for a person stays one.
#include "meshes/weld.hpp"

#include <gtest/gtest.h>

#include <random>

#include "scene/scene_text.hpp"
#include "small_worlds.hpp"

namespace unibody::weld_test {
namespace {

TEST(Weld, NodesGoToTheFirstThatStaysWithinTheDistance) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> in(0, 1);
  std::vector<Vec3> nodes;
  for (int k = 0; k < 400; ++k) nodes.emplace_back(in(random), in(random), in(random));
  for (int k = 0; k < 400; ++k)
    nodes.push_back(nodes[static_cast<std::size_t>(k)] + 0.04 * Vec3(in(random), in(random), in(random)));
  const double distance = 0.05;
  std::vector<Vec3> kept;  // by brute force
  std::vector<std::int32_t> expected;
  for (const Vec3& x : nodes) {
    const auto near = std::find_if(kept.begin(), kept.end(), [&](const Vec3& y) { return (x - y).norm() <= distance; });
    expected.push_back(static_cast<std::int32_t>(near - kept.begin()));
    if (near == kept.end()) kept.push_back(x);
  }
  std::vector<Vec3> welded = nodes;
  EXPECT_EQ(weld(welded, distance), expected);
  EXPECT_EQ(welded, kept);
  EXPECT_LT(welded.size(), 500u);
  std::vector<Vec3> same = nodes;
  const auto number = weld(same, 0);
  EXPECT_EQ(same, nodes);
  for (std::size_t k = 0; k < number.size(); ++k) EXPECT_EQ(number[k], static_cast<std::int32_t>(k));
}

TEST(Weld, ManyNodesAtOnePlaceAreOne) {
  std::vector<Vec3> nodes(300'000, Vec3(1, 2, 3));  // 10^11 pairs
  weld(nodes, 1e-6);
  EXPECT_EQ(nodes.size(), 1u);
}

// A strip of 2 x 8 cells of 0.1 m as two halves that share no node, those of the seam `off` from each other.
std::string strip(double off) {
  std::ostringstream text;
  text.precision(17);
  for (int half = 0; half < 2; ++half)
    for (int i = 0; i <= 4; ++i)
      for (int j = 0; j <= 2; ++j)
        text << "v " << 0.1 * (i + 4 * half) + (half == 1 && i == 0 ? off : 0) << ' ' << 0.1 * j << " 0\n";
  for (int half = 0; half < 2; ++half)
    for (int i = 0; i < 4; ++i)
      for (int j = 0; j < 2; ++j) {
        const int a = 1 + 15 * half + 3 * i + j;
        text << "f " << a << ' ' << a + 3 << ' ' << a + 4 << ' ' << a + 1 << '\n';
      }
  return text.str();
}

std::string cloth_of(const TextFile& file, const std::string& more) {
  return "cloths:\n  - mesh: " + file.path().substr(file.path().rfind('/') + 1) + "\n    mass: 1\n    thickness: 0.01\n" + more;
}

TEST(Weld, AClothWithASeamHangsTogether) {
  for (const double off : {0.0, 1e-8, 4e-7}) {  // of 0.8 m: within 1e-6 of it
    const TextFile file(strip(off), ".obj");
    const std::string pins = "    pins: [{within: {min: [-1, -1, -1], max: [0.01, 1, 1]}}]\n";
    const Scene scene = small_worlds::scene_from_text(cloth_of(file, pins));
    EXPECT_EQ(scene.body_count(), 27);
    ASSERT_EQ(scene.notes.size(), 1u);
    EXPECT_NE(scene.notes[0].find("30 nodes, of which 3 were welded"), std::string::npos) << scene.notes[0];
    EXPECT_NE(scene.notes[0].find("; 1 part"), std::string::npos) << scene.notes[0];
    small_worlds::Experiment run(scene);
    run.seconds(2);  // apart, the free half would have fallen by 20 m
    for (Id id = 0; id < 27; ++id) EXPECT_GT(run.position(id).z(), -1.0) << id;
  }
}

TEST(Weld, CanBeTurnedOff) {
  const TextFile file(strip(0), ".obj");
  const Scene scene = small_worlds::scene_from_text(cloth_of(file, "    weld: 0\n"));
  EXPECT_EQ(scene.body_count(), 30);
  ASSERT_EQ(scene.notes.size(), 1u);
  EXPECT_NE(scene.notes[0].find("none welded; 2 parts"), std::string::npos) << scene.notes[0];
}

TEST(Weld, LeavesApartWhatIsApart) {
  const TextFile file(strip(1e-5), ".obj");
  EXPECT_EQ(small_worlds::scene_from_text(cloth_of(file, "")).body_count(), 30);
  EXPECT_EQ(small_worlds::scene_from_text(cloth_of(file, "    weld: 1.0e-4\n")).body_count(), 27);
}

// Pins name nodes as the file numbers them: node 16 of the file, the second half's second node of the seam, is node 13 of the
// cloth.
TEST(Weld, PinsKeepTheFilesNumbers) {
  const TextFile file(strip(0), ".obj");
  const Scene scene = small_worlds::scene_from_text(cloth_of(file, "    pins: [{node: 16}, {node: 29}]\n"));
  ASSERT_EQ(scene.pins.size(), 2u);
  EXPECT_LT((scene.body(scene.pins[0].id).state.position - Vec3(0.4, 0.1, 0)).norm(), 1e-12);
  EXPECT_LT((scene.body(scene.pins[1].id).state.position - Vec3(0.8, 0.2, 0)).norm(), 1e-12);
  EXPECT_EQ(scene.pins[1].id, 26);
}

// Two tetrahedra that share a face whose nodes the file gives twice.
TEST(Weld, ASolidWithASeamIsOne) {
  const TextFile file(
      "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n8\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n5 1 0 0\n6 0 1 0\n7 1.0e-8 0 1\n"
      "8 1 1 1\n$EndNodes\n$Elements\n2\n1 4 2 1 1 1 2 3 4\n2 4 2 1 1 5 6 7 8\n$EndElements\n",
      ".msh");
  const std::string solid = "solids:\n  - mesh: " + file.path().substr(file.path().rfind('/') + 1) +
                            "\n    density: 1000\n    youngs_modulus: 1.0e+5\n    poissons_ratio: 0.3\n    thickness: 0.01\n";
  const Scene scene = small_worlds::scene_from_text(solid);
  EXPECT_EQ(scene.body_count(), 5);
  EXPECT_EQ(scene.surfaces[0].count, 6);  // the face between them is none of the surface
  EXPECT_EQ(small_worlds::scene_from_text(solid + "    weld: 0\n").body_count(), 8);
}

// A closed box of six sides that share no node is closed once they are welded.
TEST(Weld, ARigidMeshWithSeamsIsClosed) {
  std::ostringstream text;
  int node = 0;
  for (int axis = 0; axis < 3; ++axis)
    for (const int side : {-1, 1}) {
      for (const auto& [u, v] : {std::pair(-1, -1), std::pair(1, -1), std::pair(1, 1), std::pair(-1, 1)}) {
        Vec3 x;
        x[axis] = side, x[(axis + 1) % 3] = u, x[(axis + 2) % 3] = v;
        text << "v " << x.transpose() << '\n';
      }
      text << "f " << node + 1 << ' ' << node + (side > 0 ? 2 : 4) << ' ' << node + 3 << ' ' << node + (side > 0 ? 4 : 2) << '\n';
      node += 4;
    }
  const TextFile file(text.str(), ".obj");
  const std::string name = file.path().substr(file.path().rfind('/') + 1);
  const Scene scene = small_worlds::scene_from_text("bodies:\n  - {shape: {compound: {mesh: " + name + "}}, density: 1}\n");
  EXPECT_NEAR(scene.body(0).properties.mass, 8, 1e-9);
  EXPECT_NE(fault_of("bodies:\n  - {shape: {compound: {mesh: " + name + ", weld: 0}}, density: 1}\n"), "");
}

TEST(Weld, IsRefusedWhereThereIsNoMesh) {
  EXPECT_NE(fault_of("cloths:\n  - {grid: {size: [1, 1], nodes: [3, 3]}, mass: 1, thickness: 0.1, weld: 0}\n")
                .find("key 'cloths[0].weld': found 0, expected no such key"),
            std::string::npos);
  const TextFile file(strip(0), ".obj");
  EXPECT_NE(fault_of(cloth_of(file, "    weld: -1\n")).find("key 'cloths[0].weld': found -1"), std::string::npos);
}

}  // namespace
}  // namespace unibody::weld_test
