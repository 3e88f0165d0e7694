// What the reader makes of a good file: defaults, every key, values from the command line, ids and names.
#include <filesystem>

#include "scene/scene_text.hpp"

namespace unibody::read_test {
namespace {

TEST(ReadScene, DefaultsHoldWhereTheFileIsSilent) {
  const Scene scene = scene_from(ball);
  EXPECT_EQ(scene.title, "");
  EXPECT_EQ(scene.time.frame, 0.016);
  EXPECT_EQ(scene.time.frames, 400);
  EXPECT_EQ(scene.time.substeps, 1);
  EXPECT_EQ(scene.gravity, Vec3(0, 0, -9.81));
  EXPECT_FALSE(scene.planar);
  EXPECT_EQ(scene.solver.name, "accelerated_jacobi");
  EXPECT_EQ(scene.solver.iterations, SolverSettings{}.iterations);
  EXPECT_EQ(scene.output.every, 1);
  EXPECT_EQ(scene.output.checkpoint_every, 100);
  EXPECT_FALSE(scene.output.single_precision);
  EXPECT_EQ(scene.materials, std::vector<std::string>{"default"});
  EXPECT_EQ(scene.friction, std::vector<double>{0.5});
  ASSERT_EQ(scene.body_count(), 1);
  const Body body = scene.body(0);
  EXPECT_EQ(body.id, 0);
  EXPECT_EQ(body.properties.shape.kind, ShapeKind::sphere);
  EXPECT_EQ(body.properties.shape.size.x(), 0.1);
  EXPECT_EQ(body.properties.mass, 2);
  EXPECT_EQ(body.properties.motion, Motion::dynamic);
  EXPECT_NEAR(body.properties.inertia.x(), 0.4 * 2 * 0.01, 1e-15);
  EXPECT_EQ(body.state.position, Vec3(0, 0, 0));
  EXPECT_EQ(body.state.orientation.coeffs(), Quat::Identity().coeffs());
}

TEST(ReadScene, TimeOutputAndTopLevelKeys) {
  const Scene scene = scene_from(
      "title: a test\ntime: {frame: 0.01, frames: 7, substeps: 3}\ngravity: [1, 2, -3]\nplanar: false\n"
      "output: {every: 5, checkpoint_every: -1, precision: single}\n" +
      ball);
  EXPECT_EQ(scene.title, "a test");
  EXPECT_EQ(scene.time.frame, 0.01);
  EXPECT_EQ(scene.time.frames, 7);
  EXPECT_EQ(scene.time.substeps, 3);
  EXPECT_EQ(scene.gravity, Vec3(1, 2, -3));
  EXPECT_EQ(scene.output.every, 5);
  EXPECT_EQ(scene.output.checkpoint_every, -1);
  EXPECT_TRUE(scene.output.single_precision);
}

TEST(ReadScene, EverySolverKey) {
  const Scene scene = scene_from(
      "solver: {name: gauss_seidel, iterations: 12, tolerance: 1e-6, stages: position, warm_start: 0.25,\n"
      "  velocity_share: 0.75, leak: 0.3, friction: saxce, gap: reevaluated, order: sequential, scaling: 0.8, coarse: true,\n"
      "  acceleration: optimized, mass_sharing: count,\n"
      "  recovery_time: 0.032, recovery_speed: 0, margin: 0.004}\n" +
      ball);
  const SolverSettings& s = scene.solver;
  EXPECT_EQ(s.name, "gauss_seidel");
  EXPECT_EQ(s.iterations, 12);
  EXPECT_EQ(s.tolerance, 1e-6);
  EXPECT_EQ(s.stages, Stages::position);
  EXPECT_EQ(s.warm_start, 0.25);
  EXPECT_EQ(s.velocity_share, 0.75);
  EXPECT_EQ(s.leak, 0.3);
  EXPECT_EQ(s.friction, FrictionModel::saxce);
  EXPECT_EQ(s.gap, Gap::reevaluated);
  EXPECT_EQ(s.order, Order::sequential);
  EXPECT_EQ(s.acceleration, Acceleration::optimized);
  EXPECT_EQ(s.mass_sharing, MassSharing::count);
  EXPECT_TRUE(s.coarse);
  EXPECT_EQ(s.scaling, 0.8);
  EXPECT_EQ(s.recovery_time, 0.032);
  EXPECT_EQ(s.recovery_speed, 0);
  EXPECT_EQ(s.margin, 0.004);
  const SolverSettings a = scene_from(
                               "solver: {tolerance: auto, acceleration: auto, velocity_share: auto, leak: auto, recovery_time: "
                               "auto, recovery_speed: auto,\n"
                               "  margin: auto}\n" +
                               ball)
                               .solver;
  EXPECT_EQ(a.acceleration, Acceleration::automatic);
  EXPECT_EQ(a.tolerance, std::nullopt);
  EXPECT_EQ(a.velocity_share, std::nullopt);
  EXPECT_EQ(a.leak, std::nullopt);
  EXPECT_EQ(a.recovery_time, std::nullopt);
  EXPECT_EQ(a.recovery_speed, std::nullopt);
  EXPECT_EQ(a.margin, std::nullopt);
  EXPECT_EQ(a.level, Level::position);
  const SolverSettings v =
      scene_from("solver: {level: velocity, stabilisation: 0.3, warm_start: 1, iterations: 1}\n" + ball).solver;
  EXPECT_EQ(v.level, Level::velocity);
  EXPECT_EQ(v.acceleration, Acceleration::automatic);
  EXPECT_EQ(v.mass_sharing, MassSharing::directions);
  EXPECT_EQ(v.stabilisation, 0.3);
  EXPECT_EQ(v.warm_start, 1);
}

TEST(ReadScene, FrictionOfPairs) {
  const Scene scene = scene_from(
      "materials: {wood: {friction: 0.5}, ice: {friction: 0.02}, rubber: {friction: 0.8},\n"
      "  pairs: [{between: [ice, wood], friction: 0.1}]}\n"
      "bodies: [{shape: {sphere: {radius: 1}}, mass: 1, material: rubber}, {shape: {sphere: {radius: 1}}, mass: 1}]\n");
  ASSERT_EQ(scene.materials, (std::vector<std::string>{"wood", "ice", "rubber"}));
  EXPECT_EQ(scene.friction_of(0, 0), 0.5);
  EXPECT_EQ(scene.friction_of(1, 1), 0.02);
  EXPECT_EQ(scene.friction_of(0, 1), 0.1);
  EXPECT_EQ(scene.friction_of(1, 0), 0.1);
  EXPECT_DOUBLE_EQ(scene.friction_of(0, 2), std::sqrt(0.5 * 0.8));
  EXPECT_EQ(scene.friction_of(0, 2), scene.friction_of(2, 0));
  EXPECT_EQ(scene.body(0).properties.material, 2);
  EXPECT_EQ(scene.body(1).properties.material, 0);  // the first one where the entry names none
}

TEST(ReadScene, EveryBodyKey) {
  const Scene scene = scene_from(
      "bodies:\n  - {name: crate, shape: {box: {size: [1, 2, 4]}}, density: 10, inertia: [3, 4, 5], position: [1, 2, 3],\n"
      "     orientation: [0.6, 0, 0.8, 0], velocity: [4, 5, 6], angular_velocity: [7, 8, 9], force: [1, 0, 0], torque: [0, 1, "
      "0]}\n"
      "  - {shape: {box: {size: [1, 2, 4]}}, motion: kinematic, velocity: [1, 0, 0], angular_velocity: [0, 0, 2],\n"
      "     orientation: {axis: [0, 0, 1], angle: 90}}\n"
      "  - {shape: {sphere: {radius: 1}}, motion: fixed}\n");
  const Body crate = scene.body(0);
  EXPECT_EQ(crate.properties.shape.size, Vec3(0.5, 1, 2));
  EXPECT_DOUBLE_EQ(crate.properties.mass, 80);
  EXPECT_EQ(crate.properties.inertia, Vec3(3, 4, 5));
  EXPECT_EQ(crate.state.position, Vec3(1, 2, 3));
  EXPECT_NEAR(crate.state.orientation.angularDistance(Quat(0.6, 0, 0.8, 0)), 0, 1e-15);
  EXPECT_EQ(crate.state.velocity, Vec3(4, 5, 6));
  EXPECT_EQ(crate.state.angular_velocity, Vec3(7, 8, 9));
  EXPECT_EQ(crate.properties.force, Vec3(1, 0, 0));
  EXPECT_EQ(crate.properties.torque, Vec3(0, 1, 0));
  const Body door = scene.body(1);
  EXPECT_EQ(door.properties.motion, Motion::kinematic);
  EXPECT_EQ(door.state.velocity, Vec3(1, 0, 0));
  EXPECT_EQ(door.state.angular_velocity, Vec3(0, 0, 2));
  EXPECT_NEAR((door.state.orientation * Vec3::UnitX() - Vec3::UnitY()).norm(), 0, 1e-15);
  EXPECT_EQ(scene.body(2).properties.motion, Motion::fixed);
  EXPECT_FALSE(scene.groups[0].is_static);
  EXPECT_TRUE(scene.groups[1].is_static);
  EXPECT_TRUE(scene.groups[2].is_static);
}

TEST(ReadScene, PlaneLooksAlongItsNormal) {
  for (const Vec3& n :
       {Vec3(0, 0, 1), Vec3(0, 0, -1), Vec3(1, 0, 0), Vec3(0, -1, 0), Vec3(0.6, 0, -0.8), Vec3(0.48, 0.6, 0.64)}) {
    std::ostringstream text;
    text << "bodies: [{shape: {plane: {normal: [" << n.x() << ", " << n.y() << ", " << n.z() << "]}}, position: [1, 2, 3]}]";
    const Body plane = scene_from(text.str()).body(0);
    EXPECT_NEAR((plane.state.orientation * Vec3::UnitZ() - n).norm(), 0, 1e-15) << n.transpose();
    EXPECT_NEAR(plane.state.orientation.norm(), 1, 1e-15);
    EXPECT_EQ(plane.state.position, Vec3(1, 2, 3));
    EXPECT_EQ(plane.properties.motion, Motion::fixed);
    EXPECT_EQ(plane.properties.shape.kind, ShapeKind::plane);
  }
}

TEST(ReadScene, PlanarScene) {
  const Scene scene = scene_from(
      "planar: true\nbodies:\n  - {shape: {disc: {radius: 0.2}}, density: 10, position: [1, 0, 2],\n"
      "     velocity: [1, 0, 2], angular_velocity: [0, 3, 0], orientation: {axis: [0, 1, 0], angle: 30}}\n"
      "  - {shape: {plane: {normal: [0, 0, -1]}}}\n");
  const Body disc = scene.body(0);
  EXPECT_TRUE(scene.planar);
  EXPECT_EQ(disc.properties.shape.kind, ShapeKind::disc);
  EXPECT_NEAR(disc.properties.mass, 10 * M_PI * 0.04, 1e-15);
  EXPECT_NEAR(disc.properties.inertia.y(), 0.5 * disc.properties.mass * 0.04, 1e-15);
  EXPECT_EQ(scene.body(1).state.orientation.x(), 0);  // turned about y alone
  EXPECT_EQ(scene.body(1).state.orientation.z(), 0);
}

TEST(ReadScene, IdsRunOnInTheOrderOfTheFile) {
  const Scene scene = scene_from(
      "bodies:\n  - {name: ground, shape: {plane: {normal: [0, 0, 1]}}}\n  - {shape: {sphere: {radius: 1}}, mass: 1}\n"
      "  - {name: pile, shape: {sphere: {radius: 1}}, mass: 1, stack: {count: 5}}\n  - {name: top, shape: {sphere: {radius: 1}}, "
      "mass: 1}\n");
  ASSERT_EQ(scene.body_count(), 8);
  for (Id id = 0; id < 8; ++id) EXPECT_EQ(scene.body(id).id, id);
  EXPECT_EQ(scene.groups[2].first, 2);
  EXPECT_EQ(scene.groups[3].first, 7);
  EXPECT_EQ(scene.body_name(0), "ground");
  EXPECT_EQ(scene.body_name(1), "body 1");
  EXPECT_EQ(scene.body_name(2), "pile[0]");
  EXPECT_EQ(scene.body_name(6), "pile[4]");
  EXPECT_EQ(scene.body_name(7), "top");
  EXPECT_THROW(scene.body(8), std::out_of_range);
  EXPECT_THROW(scene.body(-1), std::out_of_range);
}

TEST(ReadScene, OverridesReplaceAndAdd) {
  const Scene scene = scene_from("time: {frames: 3}\n" + ball, {{"time.frames", "40"},
                                                                {"time.substeps", "2"},
                                                                {"solver.friction", "cone"},
                                                                {"output", "{every: 4}"},
                                                                {"gravity", "[0, 0, -1]"},
                                                                {"gravity[2]", "-2"},
                                                                {"bodies[0].mass", "7"},
                                                                {"bodies[0].shape.sphere.radius", "0.5"}});
  EXPECT_EQ(scene.time.frames, 40);
  EXPECT_EQ(scene.time.substeps, 2);
  EXPECT_EQ(scene.solver.friction, FrictionModel::cone);
  EXPECT_EQ(scene.output.every, 4);
  EXPECT_EQ(scene.gravity, Vec3(0, 0, -2));
  EXPECT_EQ(scene.body(0).properties.mass, 7);
  EXPECT_EQ(scene.body(0).properties.shape.size.x(), 0.5);
}

TEST(ReadScene, OverrideOfOneAliasLeavesTheOtherAlone) {
  const Scene scene =
      scene_from("bodies:\n  - &ball {shape: {sphere: {radius: 1}}, mass: 1}\n  - *ball\n", {{"bodies[1].mass", "5"}});
  EXPECT_EQ(scene.body(0).properties.mass, 1);
  EXPECT_EQ(scene.body(1).properties.mass, 5);
}

TEST(ReadScene, TheReferencesFirstExampleWorks) {
  std::ifstream file(UNIBODY_SOURCE_DIR "/docs/scene.md");
  const std::string text((std::istreambuf_iterator<char>(file)), {});
  const auto begin = text.find("```yaml\n") + 8, end = text.find("```\n", begin);
  ASSERT_LT(end, text.size());
  EXPECT_EQ(scene_from(text.substr(begin, end - begin)).body_count(), 2);
}

// Scans are fetched, not kept: scripts/run does it.
bool lacks_its_mesh(const std::string& scene) {
  const auto begin = scene.find("results/meshes/");
  if (begin == std::string::npos) return false;
  const auto end = scene.find_first_of(" ,}\n", begin);
  return !std::filesystem::exists(std::string(UNIBODY_SOURCE_DIR "/") + scene.substr(begin, end - begin));
}

TEST(ReadScene, AllScenesOfTheProjectAreGood) {
  int scenes = 0;
  for (const auto& file : std::filesystem::directory_iterator(UNIBODY_SOURCE_DIR "/scenes")) {
    if (file.path().extension() != ".yaml") continue;
    SCOPED_TRACE(file.path().filename());
    std::ifstream text(file.path());
    const std::string head((std::istreambuf_iterator<char>(text)), {});
    EXPECT_NE(head.find("#   scripts/run scenes/" + file.path().filename().string()), std::string::npos);
    ++scenes;
    if (lacks_its_mesh(head)) {
      EXPECT_THROW(read_scene(file.path()), InputError);
      continue;
    }
    Scene scene;
    ASSERT_NO_THROW(scene = read_scene(file.path(), {{"time.frames", "2"}}));
    EXPECT_EQ(scene.time.frames, 2);
    EXPECT_FALSE(scene.title.empty());
    for (const BodyGroup& group : scene.groups)
      for (const Id k : {Id{0}, group.count / 2, group.count - 1}) {
        const Body body = scene.body(group.first + k);
        EXPECT_TRUE(body.state.position.allFinite());
        EXPECT_NEAR(body.state.orientation.norm(), 1, 1e-14);
        EXPECT_GT(body.properties.mass, 0);
        EXPECT_EQ(group.is_static, body.properties.is_static());
      }
  }
  EXPECT_GE(scenes, 14);
}

}  // namespace
}  // namespace unibody::read_test
