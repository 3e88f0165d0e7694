// Shapes in scene files: what is read, and the one clear error where it is bad.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>

#include "scene/scene_text.hpp"
#include "world/shape_library.hpp"

namespace unibody::shape_files_test {

namespace {

std::string body_of(const std::string& shape, const std::string& more = "density: 1000") {
  return "bodies:\n  - shape: {" + shape + "}\n    " + more + "\n";
}

// The surface of a block 0.2 x 0.4 x 0.6 off the origin, with one triangle left out if `open`.
std::string block(bool open) {
  std::string text;
  for (int k = 0; k < 8; ++k)
    text += "v " + std::to_string(1 + (k & 1 ? 0.2 : 0)) + " " + std::to_string(k & 2 ? 0.4 : 0) + " " +
            std::to_string(k & 4 ? 0.6 : 0) + "\n";
  text += "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\n";
  return text + (open ? "f 2 4 8\n" : "f 2 4 8 6\n");
}

}  // namespace

TEST(ShapeFiles, CapsuleAndCylinderHaveTheirLengths) {
  const Shape capsule = scene_from(body_of("capsule: {radius: 0.1, length: 0.4}")).body(0).properties.shape;
  EXPECT_EQ(capsule.kind, ShapeKind::capsule);
  EXPECT_LT((capsule.size - Vec3(0.1, 0.1, 0.3)).norm(), 1e-15);
  const Shape cylinder = scene_from(body_of("cylinder: {radius: 0.1, length: 0.4}")).body(0).properties.shape;
  EXPECT_LT((cylinder.size - Vec3(0.1, 0.1, 0.2)).norm(), 1e-15);
  EXPECT_NEAR(scene_from(body_of("cylinder: {radius: 0.1, length: 0.4}")).body(0).properties.mass, std::numbers::pi * 4, 1e-9);
}

// Mass and inertia are those of the solid; convex pieces cover its surface and do not reach out of it.
TEST(ShapeFiles, ClosedMeshHasTheMassOfItsSolid) {
  const TextFile mesh(block(false));
  const Body body = scene_from(body_of("compound: {mesh: " + mesh.path() + ", scale: 2, pieces: 3}")).body(0);
  EXPECT_NEAR(body.properties.mass, 1000 * 8 * 0.2 * 0.4 * 0.6, 1e-9);
  Vec3 moments = body.properties.inertia / body.properties.mass;
  std::sort(moments.data(), moments.data() + 3);
  EXPECT_LT((moments - Vec3(0.16 + 0.64, 0.16 + 1.44, 0.64 + 1.44) / 12).norm(), 1e-9);
  EXPECT_LT((body.state.orientation.toRotationMatrix() - Mat3::Identity()).norm(), 1e-9);
  const Compound& compound = shape_library().compounds[body.properties.shape.data];
  EXPECT_LT((compound.size - Vec3(0.2, 0.4, 0.6)).norm(), 1e-9);
}

// An L of two blocks, 1 x 1 x 3 and 1 x 1 x 1 m, beside each other along x.
constexpr const char* angle_surface =
    "v 0 0 0\nv 2 0 0\nv 2 0 1\nv 1 0 1\nv 1 0 3\nv 0 0 3\nv 0 1 0\nv 2 1 0\nv 2 1 1\nv 1 1 1\nv 1 1 3\nv 0 1 3\n"
    "f 1 2 3 4\nf 1 4 5 6\nf 10 9 8 7\nf 12 11 10 7\nf 1 7 8 2\nf 2 8 9 3\nf 3 9 10 4\nf 4 10 11 5\nf 5 11 12 6\nf 6 12 7 1\n";

std::string block_between(const Vec3& low, const Vec3& high, int before) {
  std::string text;
  for (int k = 0; k < 8; ++k) {
    text += "v";
    for (int axis = 0; axis < 3; ++axis) text += " " + std::to_string(k >> axis & 1 ? high[axis] : low[axis]);
    text += "\n";
  }
  for (const std::array<int, 4>& face :
       {std::array{1, 3, 4, 2}, {5, 6, 8, 7}, {1, 2, 6, 5}, {3, 7, 8, 4}, {1, 5, 7, 3}, {2, 4, 8, 6}}) {
    text += "f";
    for (const int corner : face) text += " " + std::to_string(corner + before);
    text += "\n";
  }
  return text;
}

TEST(ShapeFiles, ConvexPiecesMayComeFromAFile) {
  const TextFile mesh(angle_surface, ".obj"),
      pieces(block_between(Vec3(0, 0, 0), Vec3(1, 1, 3), 0) + block_between(Vec3(1, 0, 0), Vec3(2, 1, 1), 8), ".obj");
  const auto shape = [&](const std::string& more) {
    return body_of("compound: {mesh: " + mesh.path() + ", scale: 0.5, " + more + "}");
  };
  const Body body = scene_from(shape("pieces_file: " + pieces.path())).body(0);
  EXPECT_NEAR(body.properties.mass, 1000 * 4 * 0.125, 1e-9);
  const Compound& compound = shape_library().compounds[body.properties.shape.data];
  ASSERT_EQ(compound.parts.size(), 2u);
  const Vec3 centre = 0.5 * Vec3((3 * 0.5 + 1.5) / 4, 0.5, (3 * 1.5 + 0.5) / 4);  // m, of mass, in the mesh's axes
  EXPECT_NEAR(shape_library().hulls[compound.parts[0].shape.data].volume, 3 * 0.125, 1e-12);
  EXPECT_NEAR(shape_library().hulls[compound.parts[1].shape.data].volume, 0.125, 1e-12);
  EXPECT_LT((body.state.orientation * compound.parts[0].place + centre - 0.5 * Vec3(0.5, 0.5, 1.5)).norm(), 1e-12);
  EXPECT_LT((body.state.orientation * compound.parts[1].place + centre - 0.5 * Vec3(1.5, 0.5, 0.5)).norm(), 1e-12);

  const TextFile longer(block_between(Vec3(0, 0, 0), Vec3(2, 1, 3.2), 0), ".obj"),
      flat("v 0 0 0\nv 2 1 3\nv 0 1 3\nf 1 2 3\n", ".obj");
  const auto told = [&](const TextFile& file) {
    std::string message = fault_of(shape("pieces_file: " + file.path()));
    return message.substr(message.find(".obj, ") + 4);
  };
  EXPECT_EQ(
      told(longer),
      ", whose pieces reach to [1, 0.5, 1.6] m, by scale and up, expected pieces that reach as far as the mesh, to [1, 0.5, "
      "1.5] m, within 5 % of its longest side");
  EXPECT_EQ(told(mesh),
            ", of which part 0 of 1 (numbered from 0) encloses 0.5 of its hull's 0.625 m^3, expected convex pieces, each "
            "a closed surface of its own");
  EXPECT_EQ(told(flat).substr(0, 58), ", of which part 0 of 1 (numbered from 0) spans no volume: ");
  EXPECT_EQ(fault_of(shape("pieces: 3, pieces_file: " + pieces.path())),
            "FILE:2: key 'bodies[0].shape.compound.pieces': found 3, expected no such key beside pieces_file");
}

// Of a file whose y axis is up, y becomes z and -z becomes y, for shapes and cloths alike.
TEST(ShapeFiles, TheYAxisOfAFileMayPointUp) {
  const TextFile file("v 0 0 0\nv 1 0 0\nv 0 2 0\nv 0 0 4\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n", ".obj");
  const TextFile flat("v 0 0 0\nv 1 0 0\nv 0 2 0\nf 1 2 3\n", ".obj");
  const auto name = [](const TextFile& of) { return of.path().substr(of.path().rfind('/') + 1); };
  const Scene scene =
      scene_from("bodies: [{shape: {hull: {mesh: " + name(file) +
                 ", scale: 0.5, up: y}}, mass: 1}]\ncloths: [{mesh: " + name(flat) + ", up: y, mass: 1, thickness: 0.01}]\n");
  const Body body = scene.body(0);
  const Hull& hull = shape_library().hulls[body.properties.shape.data];
  Vec3 high = Vec3::Constant(-HUGE_VAL);
  for (const Vec3& x : hull.corners) high = high.cwiseMax(body.state.orientation * x);
  EXPECT_LT((high - (Vec3(0.5, 0, 1) - Vec3(0.125, -0.5, 0.25))).norm(), 1e-12);  // less the centre
  EXPECT_LT((scene.body(3).state.position - Vec3(0, 0, 2)).norm(), 1e-15);
}

TEST(ShapeFiles, TerrainIsStatic) {
  const Scene scene =
      scene_from("bodies:\n  - {shape: {mesh: {height_field: {size: [2, 2], cells: [1, 1], heights: [0, 0, 0, 1]}}}}\n");
  EXPECT_TRUE(scene.groups[0].is_static);
  const MeshSurface& mesh = shape_library().meshes[scene.body(0).properties.shape.data];
  EXPECT_EQ(mesh.triangles.size(), 2u);
  EXPECT_EQ(mesh.nodes[3], Vec3(1, 1, 1));
}

TEST(ShapeFiles, RestitutionOfAPairIsTheSmallerUnlessListed) {
  const Scene scene = scene_from(ball +
                                 "materials:\n  a: {friction: 1, restitution: 0.5}\n  b: {friction: 1, restitution: 0.2}\n"
                                 "  c: {friction: 1}\n  pairs: [{between: [a, c], restitution: 0.9}]\n");
  EXPECT_EQ(scene.pairs[PairValue::restitution], (std::vector<double>{0.5, 0.2, 0.9, 0.2, 0.2, 0, 0.9, 0, 0}));
  const Scene rolling = scene_from(ball +
                                   "materials:\n  a: {friction: 1, rolling_friction: 0.04}\n  b: {friction: 1, rolling_friction: "
                                   "0.01}\n  c: {friction: 1}\n  pairs: [{between: [a, c], spinning_friction: 0.3}]\n");
  EXPECT_EQ(rolling.pairs[PairValue::rolling], (std::vector<double>{0.04, 0.02, 0, 0.02, 0.01, 0, 0, 0, 0}));
  EXPECT_EQ(rolling.pairs[PairValue::spinning], (std::vector<double>{0, 0, 0.3, 0, 0, 0, 0.3, 0, 0}));
  EXPECT_EQ(scene.friction_of(0, 2), 1);
}

TEST(ShapeFiles, BadShapesAreRefused) {
  const TextFile open(block(true));
  const std::string hull = "FILE:2: key 'bodies[0].shape.hull", solid = "points that span a solid";
  EXPECT_EQ(fault_of(body_of("capsule: {radius: 0.1}")),
            "FILE:2: key 'bodies[0].shape.capsule.length': found nothing, expected a number > 0 (m)");
  EXPECT_EQ(fault_of(body_of("cylinder: {radius: 0, length: 1}")),
            "FILE:2: key 'bodies[0].shape.cylinder.radius': found 0, expected a number > 0 (m)");
  EXPECT_EQ(fault_of(body_of("hull: {points: [[0, 0, 0], [1, 0, 0], [0, 1, 0]]}")),
            hull + ".points': found 3 points, expected " + solid);
  EXPECT_EQ(fault_of(body_of("hull: {points: [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]]}")),
            hull + ".points': found points that lie in one plane, expected " + solid);
  EXPECT_EQ(fault_of(body_of("hull: {}")), hull + "': found both or none of points and mesh, expected one of the two");
  const std::string missing =
      ": found FOLDER/no/part.stl, which isn't there, expected an OBJ, STL, PLY, glTF or DAE file, its path from the scene's "
      "folder";
  for (const std::string shape : {"hull.mesh", "compound.mesh", "mesh.file"}) {
    const auto dot = shape.find('.');
    EXPECT_EQ(fault_of(body_of(shape.substr(0, dot) + ": {" + shape.substr(dot + 1) + ": no/part.stl}", "motion: fixed")),
              "FILE:2: key 'bodies[0].shape." + shape + "'" + missing);
  }
  EXPECT_EQ(fault_of(body_of("mesh: {height_field: {size: [1.0e+9, 1], cells: [1, 1], heights: [0, 0, 0, 0]}}", "motion: fixed")),
            "FILE:2: key 'bodies[0].shape.mesh.height_field': found triangle 0 without area, expected a height of 1e-8 of the "
            "longest edge");
  EXPECT_EQ(
      fault_of(body_of("mesh: {tube: {radius: 1.0e-9, length: 1}}", "motion: fixed")),
      "FILE:2: key 'bodies[0].shape.mesh.tube': found triangle 0 without area, expected a height of 1e-8 of the longest edge");
  const std::string finite = "expected a mass and an inertia > 0 and finite for a body of this size";
  EXPECT_EQ(fault_of(body_of("capsule: {radius: 1.0e+300, length: 1}", "mass: 1")),
            "FILE:3: key 'bodies[0].mass': found 1, " + finite);
  EXPECT_EQ(fault_of(body_of("compound: {parts: [{shape: {sphere: {radius: 1.0e+300}}}]}", "mass: 1")),
            "FILE:3: key 'bodies[0].mass': found 1, " + finite);
  const std::string hole = fault_of(body_of("compound: {mesh: " + open.path() + "}"));
  EXPECT_EQ(
      hole,
      "FILE:2: key 'bodies[0].shape.compound.mesh': found a mesh with a hole: the edge between nodes 1 and 5 (numbered from 0) "
      "has one triangle, expected a closed surface");
  EXPECT_EQ(fault_of(body_of("compound: {parts: [{shape: {plane: {normal: [0, 0, 1]}}}]}")),
            "FILE:2: key 'bodies[0].shape.compound.parts[0].shape': found a plane in a compound, expected a convex solid");
  EXPECT_EQ(fault_of(body_of("mesh: {tube: {radius: 1, length: 1}}", "motion: dynamic")),
            "FILE:3: key 'bodies[0].motion': found dynamic, expected fixed or kinematic for a mesh");
  EXPECT_EQ(
      fault_of(body_of("mesh: {height_field: {size: [1, 1], cells: [1, 1], heights: [0, 0, 0]}}", "motion: fixed")).substr(0, 70),
      "FILE:2: key 'bodies[0].shape.mesh.height_field.heights': found [0, 0, ");
  EXPECT_EQ(fault_of("planar: true\n" + body_of("capsule: {radius: 1, length: 1}")),
            "FILE:3: key 'bodies[0].shape.capsule': found a capsule, expected sphere, box, plane or disc in a planar scene");
  EXPECT_EQ(fault_of(ball + "materials: {a: {friction: 1, restitution: 1.5}}\n"),
            "FILE:4: key 'materials.a.restitution': found 1.5, expected a number in [0, 1]");
  EXPECT_EQ(fault_of(ball + "materials: {a: {friction: 1, rolling_friction: -1}}\n"),
            "FILE:4: key 'materials.a.rolling_friction': found -1, expected a number >= 0 (m)");
}

}  // namespace unibody::shape_files_test
