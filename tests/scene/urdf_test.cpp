// Robots from URDF files: masses, places and joints by closed forms, how they move, and one message for each fault.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "scene/scene_text.hpp"
#include "small_worlds.hpp"
#include "world/shape_library.hpp"

namespace unibody::urdf_test {

namespace {

std::string link(const std::string& name, const std::string& inside = "") {
  return "  <link name=\"" + name + "\">" + inside + "</link>\n";
}
std::string inertial(double mass, const std::string& origin, const std::string& moments) {
  return "<inertial><origin " + origin + "/><mass value=\"" + std::to_string(mass) + "\"/><inertia " + moments + "/></inertial>";
}
std::string collision(const std::string& geometry, const std::string& origin = "xyz=\"0 0 0\"") {
  return "<collision><origin " + origin + "/><geometry>" + geometry + "</geometry></collision>";
}
std::string joint(const std::string& name, const std::string& type, const std::string& parent, const std::string& child,
                  const std::string& inside) {
  return "  <joint name=\"" + name + "\" type=\"" + type + "\"><parent link=\"" + parent + "\"/><child link=\"" + child + "\"/>" +
         inside + "</joint>\n";
}

const std::string solid = "ixx=\"0.02\" iyy=\"0.03\" izz=\"0.04\"";

// A base; an arm of two hinges about y, with a tool fixed to its end; a finger that slides, and one that goes with it.
const std::string arm =
    "<robot name=\"arm\">\n" + link("base", collision("<box size=\"0.2 0.2 0.1\"/>")) +
    link("upper", inertial(2, "xyz=\"0.1 0 0.2\" rpy=\"0 0 1.5707963267948966\"", solid) +
                      collision("<cylinder radius=\"0.05\" length=\"0.4\"/>", "xyz=\"0 0 0.2\"")) +
    link("lower", inertial(1, "xyz=\"0 0 0.1\"", solid) + collision("<box size=\"0.1 0.1 0.3\"/>", "xyz=\"0 0 0.15\"")) +
    link("tool",
         inertial(0.5, "xyz=\"0 0 0.05\" rpy=\"1.5707963267948966 0 0\"", solid) + collision("<sphere radius=\"0.06\"/>")) +
    link("left", inertial(0.1, "xyz=\"0 0 0\"", solid)) + link("right", inertial(0.1, "xyz=\"0 0 0\"", solid)) +
    joint("shoulder", "revolute", "base", "upper",
          "<origin xyz=\"0 0 0.1\"/><axis xyz=\"0 2 0\"/><limit lower=\"-1.5\" upper=\"2\"/><dynamics damping=\"0.3\" "
          "friction=\"0.2\"/>") +
    joint("elbow", "continuous", "upper", "lower", "<origin xyz=\"0 0 0.4\"/><axis xyz=\"0 1 0\"/>") +
    joint("weld", "fixed", "lower", "tool", "<origin xyz=\"0 0 0.3\"/>") +
    joint("grip", "prismatic", "tool", "left", "<axis xyz=\"1 0 0\"/><limit lower=\"0\" upper=\"0.2\"/>") +
    joint("follow", "prismatic", "tool", "right",
          "<axis xyz=\"-1 0 0\"/><limit lower=\"0\" upper=\"0.2\"/><mimic joint=\"grip\" multiplier=\"2\" offset=\"0.01\"/>") +
    "  <transmission/><gazebo/><gazebo/>\n</robot>\n";

// A file of a robot beside the scene's, with the entry's further keys.
std::string entry(const TextFile& file, const std::string& more = "", const std::string& beside = "") {
  const std::string name = file.path().substr(file.path().rfind('/') + 1);
  return "bodies:\n  - {name: r, " + beside + "urdf: {file: " + name + more + "}}\n";
}

Mat3 inertia_of(const Body& body) {  // in the axes of the robot's frame, where it stands unturned
  const Mat3 axes = body.state.orientation.toRotationMatrix();
  return axes * body.properties.inertia.asDiagonal() * axes.transpose();
}
Mat3 moved(const Vec3& moments, double mass, const Vec3& by) {
  return Mat3(moments.asDiagonal()) + mass * (by.squaredNorm() * Mat3::Identity() - by * by.transpose());
}

}  // namespace

TEST(Urdf, BodiesHaveTheMassOfTheirLinks) {
  const TextFile file(arm, ".urdf");
  const Scene scene = scene_from(entry(file));
  ASSERT_EQ(scene.body_count(), 5);  // the tool is one with the lower arm
  EXPECT_EQ(scene.body_name(2), "r/lower");
  const Body upper = scene.body(1), lower = scene.body(2);
  EXPECT_NEAR(upper.properties.mass, 2, 1e-15);
  EXPECT_LT((upper.state.position - Vec3(0.1, 0, 0.3)).norm(), 1e-15);
  EXPECT_LT((inertia_of(upper) - Mat3(Vec3(0.03, 0.02, 0.04).asDiagonal())).norm(), 1e-12);  // a quarter turn about z
  EXPECT_NEAR(lower.properties.mass, 1.5, 1e-15);
  const double centre = (1 * 0.1 + 0.5 * 0.35) / 1.5;
  EXPECT_LT((lower.state.position - Vec3(0, 0, 0.5 + centre)).norm(), 1e-14);
  const Mat3 expected =
      moved({0.02, 0.03, 0.04}, 1, Vec3(0, 0, 0.1 - centre)) + moved({0.02, 0.04, 0.03}, 0.5, Vec3(0, 0, 0.35 - centre));
  EXPECT_LT((inertia_of(lower) - expected).norm(), 1e-12);
  ASSERT_EQ(scene.notes.size(), 1U);
  EXPECT_NE(scene.notes[0].find("left out gazebo (2), transmission (1)"), std::string::npos) << scene.notes[0];
}

// A link that is fixed to another names the same body: here in a joint and in a probe.
TEST(Urdf, FixedLinksNameTheirBody) {
  const TextFile file(arm, ".urdf");
  const Scene scene = scene_from(entry(file) +
                                 "joints:\n  - {type: ball, bodies: [r/tool, world], anchor: [0, 0, 0]}\nprobes:\n  - {name: f, "
                                 "force: {on: r/tool, by: r/lower}}\n");
  EXPECT_EQ(scene.joints.back().ids[0], 2);
  EXPECT_EQ(scene.body_name(2), "r/lower");
  EXPECT_EQ(
      fault_of(entry(file) + "joints:\n  - {type: ball, bodies: [r/tol, world], anchor: [0, 0, 0]}\n"),
      "FILE:4: key 'joints[0].bodies[0]': found r/tol, a name that no part of r has, expected the name of a body, as door or "
      "pile[3], its entry's place in the list, or world");
}

TEST(Urdf, MomentsThatNoSolidHasAreTold) {
  const TextFile file(
      "<robot name=\"m\">\n" + link("m", inertial(1, "xyz=\"0 0 0\"", "ixx=\"1\" iyy=\"1\" izz=\"3\"")) + "</robot>\n", ".urdf");
  const Scene scene = scene_from(entry(file, ", base: free"));
  ASSERT_EQ(scene.notes.size(), 1U);
  EXPECT_NE(scene.notes[0].find("link m has moments of inertia that no solid has"), std::string::npos) << scene.notes[0];
  EXPECT_NEAR(scene.body(0).properties.inertia.maxCoeff(), 3, 1e-12);
}

// x = l1 sin q1 + ... of both hinges about y, from where the entry places the base.
TEST(Urdf, JointsStartWhereTheEntrySays) {
  const TextFile file(arm, ".urdf");
  const Scene scene = scene_from(entry(
      file, ", joints: [{name: shoulder, at: 30}, {name: elbow, at: 40}, {name: grip, at: 0.05}]", "position: [1, 2, 3], "));
  const double a = 30 * M_PI / 180, b = 70 * M_PI / 180, centre = (1 * 0.1 + 0.5 * 0.35) / 1.5;
  const Vec3 along(std::sin(a), 0, std::cos(a)), across(std::cos(a), 0, -std::sin(a)), next(std::sin(b), 0, std::cos(b)),
      aside(std::cos(b), 0, -std::sin(b)), shoulder(1, 2, 3.1), elbow = shoulder + 0.4 * along;
  EXPECT_LT((scene.body(1).state.position - (shoulder + 0.1 * across + 0.2 * along)).norm(), 1e-14);
  EXPECT_LT((scene.body(2).state.position - (elbow + centre * next)).norm(), 1e-14);
  EXPECT_LT((scene.body(3).state.position - (elbow + 0.3 * next + 0.05 * aside)).norm(), 1e-14);
  EXPECT_LT((scene.body(4).state.position - (elbow + 0.3 * next - (2 * 0.05 + 0.01) * aside)).norm(), 1e-14);

  ASSERT_EQ(scene.joints.size(), 4U);
  const Joint& first = scene.joints[0];
  EXPECT_EQ(first.kind, JointKind::hinge);
  EXPECT_EQ(first.lower, -1.5);
  EXPECT_EQ(first.upper, 2);
  EXPECT_EQ(first.viscosity, 0.3);
  EXPECT_EQ(first.friction, 0.2);
  EXPECT_FALSE(scene.joints[1].is_limited());
  ASSERT_EQ(scene.couplings.size(), 1U);
  EXPECT_EQ(scene.couplings[0].ratio, 2);
  EXPECT_EQ(scene.joints_named.at("r/follow"), std::vector<std::size_t>{3});
  Scene weightless = scene;
  weightless.gravity.setZero();
  small_worlds::Experiment run(std::move(weightless));
  run.step();
  const auto states = run.simulation->joint_states();
  const double expected[] = {30 * M_PI / 180, 40 * M_PI / 180, 0.05, 0.11};
  for (std::size_t j = 0; j < 4; ++j) EXPECT_NEAR(states[j].coordinate, expected[j], 1e-12) << j;
}

// A rod on a hinge from a file swings as the same rod that the scene describes.
TEST(Urdf, SwingsAsTheSameBodiesOfAScene) {
  const TextFile file("<robot name=\"swing\">\n" + link("base") +
                          link("rod", inertial(2, "xyz=\"0 0 -0.5\"", "ixx=\"0.17\" iyy=\"0.17\" izz=\"0.01\"")) +
                          joint("pivot", "continuous", "base", "rod", "<axis xyz=\"0 1 0\"/>") + "</robot>\n",
                      ".urdf");
  const std::string settings = "solver: {iterations: 100, tolerance: 0}\ntime: {frame: 0.002}\n";
  small_worlds::Experiment robot(scene_from(entry(file, ", joints: [{name: pivot, at: 60}]") + settings));
  small_worlds::Experiment rod(small_worlds::scene_from_text(
      "bodies:\n  - {name: rod, shape: {sphere: {radius: 0.1}}, mass: 2, inertia: [0.17, 0.17, 0.01], position: [" +
      std::to_string(-0.5 * std::sin(M_PI / 3)) +
      ", 0, -0.25], orientation: {axis: [0, 1, 0], angle: 60}}\njoints:\n  - {type: hinge, bodies: [rod, world], anchors: [[0, "
      "0, "
      "0.5], [0, 0, 0]], axis: [0, 1, 0]}\n" +
      settings));
  for (int k = 0; k < 500; ++k) {
    robot.step(), rod.step();
    ASSERT_LT((robot.position(1) - rod.position(0)).norm(), 2e-6) << k;
  }
  EXPECT_EQ(robot.position(0), Vec3(0, 0, 0));  // the base is held
}

// A body on a planar joint falls along the plane, and not out of it. Two links between slide with it, with 1 % of its mass each.
TEST(Urdf, APlanarJointLeavesItsPlaneAlone) {
  const TextFile file("<robot name=\"p\">\n" + link("base") + link("plate", inertial(2, "xyz=\"0.1 0 0\"", solid)) +
                          joint("j", "planar", "base", "plate", "<origin xyz=\"0 0 1\"/><axis xyz=\"0 0 1\"/>") + "</robot>\n",
                      ".urdf");
  Scene scene = scene_from(entry(file) + "solver: {joints: direct}\n");
  ASSERT_EQ(scene.body_count(), 4);
  EXPECT_EQ(scene.body_name(1), "r/plate_x");
  ASSERT_EQ(scene.joints.size(), 3U);
  EXPECT_EQ(scene.joints[0].kind, JointKind::slider);
  EXPECT_EQ(scene.joints[1].kind, JointKind::slider);
  EXPECT_EQ(scene.joints[2].kind, JointKind::hinge);
  EXPECT_EQ(scene.joints_named.at("r/j_y"), std::vector<std::size_t>{1});
  EXPECT_NEAR(scene.body(1).properties.mass + scene.body(2).properties.mass + scene.body(3).properties.mass, 2, 1e-14);
  scene.gravity = Vec3(3, -2, -9.81);
  small_worlds::Experiment run(std::move(scene));
  constexpr int steps = 30;
  const double h = run.simulation->traits.step, fallen = h * h * steps * (steps + 1) / 2;
  for (int k = 0; k < steps; ++k) run.step();
  EXPECT_LT((run.position(3) - Vec3(0.1 + 3 * fallen, -2 * fallen, 1)).norm(), 1e-9);
}

// Links without collision touch nothing; the same link with one lies on the ground.
TEST(Urdf, OnlyWhatHasACollisionTouches) {
  for (const bool touches : {false, true}) {
    const TextFile file("<robot name=\"ball\">\n" +
                            link("ball", inertial(1, "xyz=\"0 0 0\"", "ixx=\"0.1\" iyy=\"0.1\" izz=\"0.1\"") +
                                             (touches ? collision("<sphere radius=\"0.2\"/>") : "")) +
                            "</robot>\n",
                        ".urdf");
    small_worlds::Experiment run(
        scene_from(entry(file, ", base: free", "position: [0, 0, 0.5], ") + "  - {shape: {plane: {normal: [0, 0, 1]}}}\n"));
    run.seconds(1);
    if (touches) {
      EXPECT_NEAR(run.position(0).z(), 0.2, 1e-4);
    } else {
      EXPECT_LT(run.position(0).z(), -3);
    }
  }
}

// A mesh is the hull of its nodes, by the factors of the file; package:// is looked for in the folders above.
TEST(Urdf, MeshesAreHulls) {
  const TextFile mesh("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n", ".obj");
  const std::string name = mesh.path().substr(mesh.path().rfind('/') + 1);
  for (const std::string& reference : {name, "file://" + mesh.path(), "package://" + name}) {
    const TextFile file(
        "<robot name=\"m\">\n" +
            link("m", inertial(1, "xyz=\"0 0 0\"", solid) +
                          collision("<mesh filename=\"" + reference + "\" scale=\"1 2 0.5\"/>", "xyz=\"0 0 3\"")) +
            "</robot>\n",
        ".urdf");
    const Scene scene = scene_from(entry(file, ", base: free"));
    const Body body = scene.body(0);
    EXPECT_NEAR(volume(body.properties.shape), 1.0 / 6, 1e-12) << reference;
    const Compound& compound = shape_library().compounds[body.properties.shape.data];
    EXPECT_LT((body.state.orientation * compound.parts[0].place - Vec3(0.25, 0.5, 3.125)).norm(), 1e-12) << reference;
  }
}

namespace {

struct Fault {
  const char* name;
  std::string robot, more, message;
};
void PrintTo(const Fault& fault, std::ostream* out) { *out << fault.name; }

class UrdfRefuses : public testing::TestWithParam<Fault> {};

std::string robot(const std::string& inside) { return "<robot name=\"r\">\n" + inside + "</robot>\n"; }
const std::string two = link("a") + link("b", inertial(1, "xyz=\"0 0 0\"", solid));

const std::vector<Fault> faults{
    {"no_xml", "<robot>\n<link", "", "2: found bad XML (Error parsing start element tag), expected a robot (URDF)"},
    {"no_robot", "<sdf/>\n", "", "1: found <sdf>, expected <robot>"},
    {"macros", robot("<xacro:macro/>\n"), "",
     "2: found <xacro:macro>, expected a robot without macros, as the program xacro makes one"},
    {"unknown_link", robot(two + joint("j", "continuous", "a", "c", "")), "",
     "4: found 'c', a name that no link has, expected the name of a link"},
    {"unknown_type", robot(two + joint("j", "sideways", "a", "b", "")), "",
     "4: found a joint of type 'sideways', expected fixed, revolute, continuous, prismatic, planar or floating"},
    {"two_roots", robot(two), "", "1: found 2 links that are nobody's child, expected one, from which joints lead to all others"},
    {"no_limit", robot(two + joint("j", "revolute", "a", "b", "")), "", "4: found no <limit> in a revolute joint, expected one"},
    {"no_number", robot(two + joint("j", "continuous", "a", "b", "<origin xyz=\"0 0 x\"/>")), "",
     "4: found xyz '0 0 x', expected 3 numbers"},
    {"no_mass", robot(link("a") + link("b") + joint("j", "continuous", "a", "b", "")), "",
     "3: found link 'b' without <inertial>, nor one of what is fixed to it, expected a mass and an inertia, since it moves"},
    {"no_inertia", robot(link("a", inertial(1, "xyz=\"0 0 0\"", "ixx=\"1\" iyy=\"1\" izz=\"1\" ixy=\"2\""))), "",
     "2: found moments of inertia that are not all > 0 about their principal axes, expected those of a solid"},
    {"other_mesh", robot(link("a", collision("<mesh filename=\"nothing.dae\"/>"))), "",
     "2: found mesh 'nothing.dae', which isn't at FOLDER/nothing.dae, expected a file that is there"},
    {"mimics_nothing", robot(two + joint("j", "continuous", "a", "b", "<mimic joint=\"k\"/>")), "",
     "4: found joint 'j' that mimics 'k', expected the name of another joint that moves by itself, and a multiplier other than "
     "0"},
};

TEST_P(UrdfRefuses, WithThisMessage) {
  const TextFile file(GetParam().robot, ".urdf");
  std::string expected = file.path() + ":" + GetParam().message;
  const std::string folder = file.path().substr(0, file.path().rfind('/'));
  if (const auto at = expected.find("FOLDER"); at != std::string::npos) expected.replace(at, 6, folder);
  try {
    scene_from(entry(file, GetParam().more));
    ADD_FAILURE() << "it is read";
  } catch (const InputError& error) {
    EXPECT_EQ(std::string(error.what()), expected);
  }
}

INSTANTIATE_TEST_SUITE_P(Faults, UrdfRefuses, testing::ValuesIn(faults), [](const auto& each) { return each.param.name; });

}  // namespace

TEST(Urdf, FaultsOfTheEntryNameItsKeys) {
  const TextFile file(arm, ".urdf");
  EXPECT_EQ(
      fault_of(entry(file, ", joints: [{name: elbo}]")),
      "FILE:2: key 'bodies[0].urdf.joints[0].name': found elbo, a name that no joint of the file has (did you mean elbow?), "
      "expected the name of a joint of the file that moves");
  EXPECT_EQ(
      fault_of(entry(file, ", joints: [{name: follow}]")),
      "FILE:2: key 'bodies[0].urdf.joints[0].name': found follow, a joint that goes with grip, expected a joint that moves by "
      "itself");
  EXPECT_EQ(fault_of(entry(file, ", joints: [{name: grip, motor: {speed: 1, max_torque: 1}}]")),
            "FILE:2: key 'bodies[0].urdf.joints[0].motor.max_torque': found an unknown key (did you mean max_force?), expected "
            "speed, offset, max_force, max_pressure or area");
}

}  // namespace unibody::urdf_test
