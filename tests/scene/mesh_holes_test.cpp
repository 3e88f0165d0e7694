// Holes of surfaces, told from outlines and rims.
#include "meshes/mesh_holes.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "scene/scene_text.hpp"
#include "small_worlds.hpp"

namespace unibody::small_worlds::mesh_holes_test {

namespace {

// n x n squares of 0.1 m in the plane z = height from the origin on, each of two triangles, but for those that are left out.
void add_sheet(TriangleMesh& mesh, int n, double height, const std::vector<std::array<int, 2>>& without = {}) {
  const auto first = static_cast<std::int32_t>(mesh.nodes.size());
  for (int j = 0; j <= n; ++j)
    for (int i = 0; i <= n; ++i) mesh.nodes.emplace_back(0.1 * i, 0.1 * j, height);
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      if (std::ranges::find(without, std::array{i, j}) != without.end()) continue;
      const std::int32_t a = first + j * (n + 1) + i, b = a + 1, c = a + n + 1, d = c + 1;
      mesh.triangles.push_back({a, b, d}), mesh.triangles.push_back({a, d, c});
    }
}

std::string obj_of(const TriangleMesh& mesh) {
  std::string text;
  for (const Vec3& x : mesh.nodes)
    text += "v " + std::to_string(x.x()) + " " + std::to_string(x.y()) + " " + std::to_string(x.z()) + "\n";
  for (const auto& t : mesh.triangles)
    text += "f " + std::to_string(t[0] + 1) + " " + std::to_string(t[1] + 1) + " " + std::to_string(t[2] + 1) + "\n";
  return text;
}

std::vector<std::string> notes_of(const TriangleMesh& mesh) {
  const TextFile file(obj_of(mesh), ".obj");
  std::vector<std::string> notes = scene_from_text("bodies: [{shape: {mesh: {file: " + file.path() + "}}}]\n").notes;
  for (std::string& note : notes)
    if (note.starts_with(file.path() + ": ")) note.erase(0, file.path().size() + 2);
  return notes;
}

}  // namespace

TEST(MeshHoles, AnOutlineIsNone) {
  TriangleMesh mesh;
  add_sheet(mesh, 10, 0);
  EXPECT_TRUE(holes_of(mesh).empty());
  add_sheet(mesh, 1, 3);  // small beside the other, but all of its own part
  EXPECT_TRUE(holes_of(mesh).empty());
  EXPECT_TRUE(notes_of(mesh).empty());
}

TEST(MeshHoles, ARimIsNone) {
  TriangleMesh mesh;  // a cup: a floor of 0.2 m and walls as high
  for (const double z : {0.0, 0.2})
    for (const auto& [x, y] : {std::pair(0.0, 0.0), {0.2, 0.0}, {0.2, 0.2}, {0.0, 0.2}}) mesh.nodes.emplace_back(x, y, z);
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  for (std::int32_t k = 0; k < 4; ++k) {
    const std::int32_t next = (k + 1) % 4;
    mesh.triangles.push_back({k, next, next + 4}), mesh.triangles.push_back({k, next + 4, k + 4});
  }
  EXPECT_TRUE(holes_of(mesh).empty());
}

TEST(MeshHoles, AreFoundWithTheirPlacesTheWidestFirst) {
  TriangleMesh mesh;
  add_sheet(mesh, 10, 0.5, {{2, 7}, {5, 4}, {6, 4}});
  const std::vector<Hole> holes = holes_of(mesh);
  ASSERT_EQ(holes.size(), 2U);
  EXPECT_EQ(holes[0].edges, 6);
  EXPECT_NEAR(holes[0].width, 0.2, 1e-12);
  EXPECT_LT((holes[0].centre - Vec3(0.6, 0.45, 0.5)).norm(), 1e-12);
  EXPECT_EQ(holes[1].edges, 4);
  EXPECT_LT((holes[1].centre - Vec3(0.25, 0.75, 0.5)).norm(), 1e-12);
  EXPECT_EQ(notes_of(mesh),
            std::vector<std::string>{"it has 2 holes, the widest 0.2 m wide, at [0.6, 0.45, 0.5] m from the mesh's "
                                     "origin: bodies may pass through"});
  mesh.triangles.clear(), mesh.nodes.clear();
  add_sheet(mesh, 10, 0, {{2, 7}});
  EXPECT_EQ(notes_of(mesh),
            std::vector<std::string>{"it has a hole, 0.1 m wide, at [0.25, 0.75, 0] m from the mesh's origin: bodies "
                                     "may pass through"});
}

}  // namespace unibody::small_worlds::mesh_holes_test
