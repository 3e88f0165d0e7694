// Models from MJCF files: masses, places and joints by closed forms, how they move, and one message for each fault.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "scene/scene_text.hpp"
#include "small_worlds.hpp"
#include "world/shape_library.hpp"

namespace unibody::mjcf_test {

namespace {

std::string model(const std::string& world, const std::string& before = "", const std::string& after = "") {
  return "<mujoco model=\"m\">\n" + before + "<worldbody>\n" + world + "</worldbody>\n" + after + "</mujoco>\n";
}

// A file of a model beside the scene's, with the entry's further keys.
std::string entry(const TextFile& file, const std::string& more = "", const std::string& beside = "") {
  const std::string name = file.path().substr(file.path().rfind('/') + 1);
  return "bodies:\n  - {name: m, " + beside + "mjcf: {file: " + name + more + "}}\n";
}

Scene read_model(const std::string& text, const std::string& more = "", const std::string& beside = "") {
  const TextFile file(text, ".xml");
  return scene_from(entry(file, more, beside));
}

Mat3 inertia_of(const Body& body) {  // in the axes of the world
  const Mat3 axes = body.state.orientation.toRotationMatrix();
  return axes * body.properties.inertia.asDiagonal() * axes.transpose();
}
Mat3 moved(const Mat3& inertia, double mass, const Vec3& by) {
  return inertia + mass * (by.squaredNorm() * Mat3::Identity() - by * by.transpose());
}
Mat3 turned(const Vec3& moments, const Quat& turn) {
  const Mat3 R = turn.toRotationMatrix();
  return R * moments.asDiagonal() * R.transpose();
}
Quat about(const Vec3& axis, double degrees) { return Quat(Eigen::AngleAxisd(degrees * M_PI / 180, axis)); }

const std::string solid = "mass=\"2\" diaginertia=\"0.02 0.03 0.04\"";

}  // namespace

// Densities and masses of geoms, and their own moments and places.
TEST(Mjcf, GeomsGiveMass) {
  const Scene scene =
      read_model(model("<body name=\"b\" pos=\"1 2 3\"><freejoint/>\n"
                       "<geom type=\"box\" size=\"0.1 0.2 0.3\" density=\"500\"/>\n"
                       "<geom type=\"capsule\" fromto=\"0 0 1 0.6 0 1.8\" size=\"0.1\" mass=\"2\"/></body>\n"
                       "<body><freejoint/><geom size=\"0.5\"/></body>\n"));
  ASSERT_EQ(scene.body_count(), 2);
  EXPECT_EQ(scene.body_name(0), "m/b");
  const double box = 500 * 8 * 0.1 * 0.2 * 0.3, mass = box + 2;
  const Vec3 at(0.3, 0, 1.4), centre = 2 / mass * at;
  const Body body = scene.body(0);
  EXPECT_NEAR(body.properties.mass, mass, 1e-13);
  EXPECT_LT((body.state.position - Vec3(1, 2, 3) - centre).norm(), 1e-14);
  // a tube of length 1 and radius 0.1, and two half balls
  const double r = 0.1, h = 0.5, tube = 2 * (2 * h) / (2 * h + 4 * r / 3), caps = 2 - tube;
  const double along = 0.5 * tube * r * r + 0.4 * caps * r * r;
  const double across = tube * (r * r / 4 + h * h / 3) + caps * (0.4 * r * r + h * h + 0.75 * h * r);
  const Quat turn = Quat::FromTwoVectors(Vec3::UnitZ(), Vec3(0.6, 0, 0.8));
  const Mat3 of_box = Mat3((box / 3 * Vec3(0.04 + 0.09, 0.01 + 0.09, 0.01 + 0.04)).asDiagonal());
  const Mat3 expected = moved(of_box, box, -centre) + moved(turned({across, across, along}, turn), 2, at - centre);
  EXPECT_LT((inertia_of(body) - expected).norm(), 1e-12);
  EXPECT_NEAR(scene.body(1).properties.mass, 1000 * 4 * M_PI / 3 * 0.125, 1e-9);
}

// An ellipsoid's mass is that of the whole; a mesh is the hull of its nodes, by its scale.
TEST(Mjcf, EllipsoidsAndMeshesAreHulls) {
  const Scene scene =
      read_model(model("<body><freejoint/><geom type=\"ellipsoid\" size=\"0.3 0.2 0.1\"/></body>\n"
                       "<body><freejoint/><geom type=\"mesh\" mesh=\"corner\" density=\"600\" pos=\"0 0 3\"/></body>\n",
                       "<asset><mesh name=\"corner\" vertex=\"0 0 0 1 0 0 0 1 0 0 0 1\" scale=\"1 2 0.5\"/></asset>\n"));
  EXPECT_NEAR(scene.body(0).properties.mass, 1000 * 4 * M_PI / 3 * 0.006, 1e-9);
  const Vec3 moments = scene.body(0).properties.mass / 5 * Vec3(0.04 + 0.01, 0.09 + 0.01, 0.09 + 0.04);
  EXPECT_LT((inertia_of(scene.body(0)) - Mat3(moments.asDiagonal())).norm(), 0.03 * moments.norm());
  EXPECT_NEAR(scene.body(1).properties.mass, 600.0 / 6, 1e-9);
  EXPECT_LT((scene.body(1).state.position - Vec3(0.25, 0.5, 3.125)).norm(), 1e-12);
}

// What an <inertial> says holds, unless the compiler says otherwise; what touches nothing still has mass.
TEST(Mjcf, InertialSaysItAll) {
  const std::string body = "<body><freejoint/><inertial pos=\"0 0 0.1\" quat=\"1 0 0 1\" " + solid +
                           "/><geom size=\"0.1\" contype=\"0\" conaffinity=\"0\"/></body>\n";
  const Scene said = read_model(model(body)), of_shapes = read_model(model(body, "<compiler inertiafromgeom=\"true\"/>\n"));
  EXPECT_EQ(said.body(0).properties.mass, 2);
  EXPECT_LT((said.body(0).state.position - Vec3(0, 0, 0.1)).norm(), 1e-15);
  EXPECT_LT((inertia_of(said.body(0)) - Mat3(Vec3(0.03, 0.02, 0.04).asDiagonal())).norm(), 1e-15);
  EXPECT_NEAR(of_shapes.body(0).properties.mass, 1000 * 4 * M_PI / 3 * 1e-3, 1e-12);
  EXPECT_TRUE(said.body(0).properties.shape.kind == ShapeKind::compound);
  small_worlds::Experiment run(read_model(model(body)));
}

// Two hinges whose axes pass beside the bodies' origins: x = anchor + R (x0 - anchor), one after the other.
TEST(Mjcf, JointsStartWhereTheEntrySays) {
  const Scene scene = read_model(
      model("<body name=\"upper\" pos=\"0 0 1\" euler=\"0 0 90\">\n"
            "<joint name=\"shoulder\" pos=\"0.1 0 0\" axis=\"0 2 0\" range=\"-80 100\" damping=\"0.3\" frictionloss=\"0.2\"/>\n"
            "<inertial pos=\"0.2 0 0\" " +
            solid +
            "/>\n"
            "<body name=\"lower\" pos=\"0.5 0 0\"><joint name=\"elbow\" axis=\"0 1 0\" stiffness=\"5\" springref=\"20\"/>\n"
            "<inertial pos=\"0.3 0 0\" " +
            solid +
            "/>\n"
            "<body name=\"tip\" pos=\"0.6 0 0\"><joint name=\"slide\" type=\"slide\" axis=\"1 0 0\" range=\"0 0.2\"/>\n"
            "<inertial pos=\"0 0 0\" " +
            solid + "/></body></body></body>\n"),
      ", joints: [{name: shoulder, at: 30}, {name: elbow, at: 40}, {name: slide, at: 0.05}]", "position: [5, 0, 0], ");
  ASSERT_EQ(scene.body_count(), 3);
  const Vec3 origin(5, 0, 1);
  const Quat first = about(Vec3::UnitZ(), 90);
  const auto in_upper = [&](const Vec3& x) -> Vec3 {
    const Vec3 anchor(0.1, 0, 0);
    return origin + first * (anchor + about(Vec3::UnitY(), 30) * (x - anchor));
  };
  const auto in_lower = [&](const Vec3& x) -> Vec3 { return in_upper(Vec3(0.5, 0, 0) + about(Vec3::UnitY(), 40) * x); };
  EXPECT_LT((scene.body(0).state.position - in_upper({0.2, 0, 0})).norm(), 1e-14);
  EXPECT_LT((scene.body(1).state.position - in_lower({0.3, 0, 0})).norm(), 1e-14);
  EXPECT_LT((scene.body(2).state.position - in_lower({0.65, 0, 0})).norm(), 1e-14);
  ASSERT_EQ(scene.joints.size(), 3U);
  EXPECT_EQ(scene.joints[0].ids[1], -1);  // to the world
  EXPECT_EQ(scene.joints[0].viscosity, 0.3);
  EXPECT_EQ(scene.joints[0].friction, 0.2);
  EXPECT_NEAR(scene.joints[0].lower, -80 * M_PI / 180, 1e-15);
  EXPECT_NEAR(scene.joints[0].upper, 100 * M_PI / 180, 1e-15);
  EXPECT_EQ(scene.joints[1].stiffness, 5);
  EXPECT_NEAR(scene.joints[1].rest, 20 * M_PI / 180, 1e-15);
  EXPECT_FALSE(scene.joints[1].is_limited());
  EXPECT_EQ(scene.joints[2].kind, JointKind::slider);
  Scene weightless = scene;
  weightless.gravity.setZero(), weightless.time.frame = 1e-6;  // so that the spring moves nothing
  small_worlds::Experiment run(std::move(weightless));
  run.step();
  const auto states = run.simulation->joint_states();
  EXPECT_NEAR(states[0].coordinate, 30 * M_PI / 180, 1e-9);
  EXPECT_NEAR(states[1].coordinate, 40 * M_PI / 180, 1e-9);
  EXPECT_NEAR(states[2].coordinate, 0.05, 1e-9);
}

// Every way to say a turn says this one, by 90 degrees about z and then by 90 about the new x.
TEST(Mjcf, TurnsAreSaidInManyWays) {
  const Quat expected = about(Vec3::UnitZ(), 90) * about(Vec3::UnitX(), 90);
  for (const auto& [before, turn] : std::vector<std::pair<std::string, std::string>>{
           {"<compiler eulerseq=\"zxy\"/>", "euler=\"90 90 0\""},
           {"<compiler eulerseq=\"XZY\" angle=\"radian\"/>", "euler=\"1.5707963267948966 1.5707963267948966 0\""},
           {"", "quat=\"0.5 0.5 0.5 0.5\""},
           {"", "xyaxes=\"0 1 0 0 3 1\""},
           {"", "axisangle=\"1 1 1 120\""}}) {
    const Scene scene = read_model(
        model("<body pos=\"0 0 1\" " + turn + "><freejoint/><inertial pos=\"1 2 3\" " + solid + "/></body>\n", before + "\n"));
    EXPECT_LT((scene.body(0).state.position - Vec3(0, 0, 1) - expected * Vec3(1, 2, 3)).norm(), 1e-14) << turn;
  }
  const Scene scene = read_model(model("<body zaxis=\"1 0 0\"><freejoint/><inertial pos=\"0 0 3\" " + solid + "/></body>\n"));
  EXPECT_LT((scene.body(0).state.position - Vec3(3, 0, 0)).norm(), 1e-14);
}

// Classes in classes, the class of a body's children, one of an element's own, and a frame.
TEST(Mjcf, DefaultsAndFrames) {
  const Scene scene =
      read_model(model("<body childclass=\"big\"><freejoint/><geom/></body>\n<body><freejoint/><geom/></body>\n"
                       "<body childclass=\"big\"><freejoint/><geom class=\"heavy\" size=\"0.3\"/></body>\n"
                       "<frame pos=\"1 0 0\" euler=\"0 0 90\"><body pos=\"1 0 0\"><freejoint/><geom/></body></frame>\n",
                       "<default><geom size=\"0.1\"/><default class=\"big\"><geom size=\"0.2\"/><default class=\"heavy\">"
                       "<geom density=\"2000\"/></default></default></default>\n"));
  const auto ball = [](double density, double r) { return density * 4 * M_PI / 3 * r * r * r; };
  EXPECT_NEAR(scene.body(0).properties.mass, ball(1000, 0.2), 1e-9);
  EXPECT_NEAR(scene.body(1).properties.mass, ball(1000, 0.1), 1e-9);
  EXPECT_NEAR(scene.body(2).properties.mass, ball(2000, 0.3), 1e-9);
  EXPECT_LT((scene.body(3).state.position - Vec3(1, 1, 0)).norm(), 1e-15);
}

TEST(Mjcf, IncludedFilesAreRead) {
  const TextFile part(
      "<mujocoinclude>\n<body name=\"inner\" pos=\"0 0 2\"><freejoint/><geom size=\"0.1\"/></body>\n</mujocoinclude>\n", ".xml");
  const std::string name = part.path().substr(part.path().rfind('/') + 1);
  EXPECT_EQ(read_model(model("<include file=\"" + name + "\"/>\n")).body(0).state.position.z(), 2);
  const TextFile faulty("<mujocoinclude>\n<body><freejoint/>\n<geom size=\"0\"/></body>\n</mujocoinclude>\n", ".xml");
  const TextFile outer(model("<include file=\"" + faulty.path().substr(faulty.path().rfind('/') + 1) + "\"/>\n"), ".xml");
  try {
    scene_from(entry(outer));
    ADD_FAILURE();
  } catch (const InputError& error) {
    EXPECT_EQ(std::string(error.what()), faulty.path() + ":3: found size '0', expected a number > 0");
  }
}

// Three hinges in one body: two links between them with 1 % of its mass each, and the turns one after the other.
TEST(Mjcf, ABodyWithThreeJoints) {
  const std::string text = model(
      "<body name=\"b\"><joint name=\"z\" axis=\"0 0 1\"/><joint name=\"y\" axis=\"0 1 0\"/><joint name=\"x\" axis=\"1 0 0\"/>\n"
      "<inertial pos=\"0.3 0.2 -0.1\" " +
      solid + "/></body>\n");
  const Scene scene = read_model(text, ", joints: [{name: z, at: 20}, {name: y, at: 30}, {name: x, at: 40}]");
  ASSERT_EQ(scene.body_count(), 3);
  double mass = 0;
  Id whole = -1;
  for (Id k = 0; k < 3; ++k) {
    mass += scene.body(k).properties.mass;
    if (scene.body_name(k) == "m/b") whole = k;
  }
  EXPECT_NEAR(mass, 2, 1e-14);
  ASSERT_GE(whole, 0);
  EXPECT_NEAR(scene.body(whole).properties.mass, 2 * 0.99 * 0.99, 1e-14);
  const Quat turn = about(Vec3::UnitZ(), 20) * about(Vec3::UnitY(), 30) * about(Vec3::UnitX(), 40);
  EXPECT_LT((scene.body(whole).state.position - turn * Vec3(0.3, 0.2, -0.1)).norm(), 1e-14);
  ASSERT_EQ(scene.notes.size(), 1U);
  EXPECT_NE(scene.notes[0].find("body b has 3 joints"), std::string::npos);
  // At rest below its pivot the centre hangs as deep as it is far away, but for what 1 % of the mass pulls aside.
  const TextFile file(
      model("<body name=\"b\"><joint axis=\"0 1 0\" damping=\"2\"/><joint axis=\"1 0 0\" damping=\"2\"/><inertial "
            "pos=\"0.3 0.2 -0.1\" " +
            solid + "/></body>\n"),
      ".xml");
  small_worlds::Experiment run(scene_from(entry(file) + "solver: {joints: direct}\n"));
  run.seconds(12);
  EXPECT_NEAR(run.position(1).z(), -Vec3(0.3, 0.2, -0.1).norm(), 1e-5);  // body 0, of 1 %, hangs beside
}

// Bodies tied into a loop, one tied to the world, and a joint that goes with another.
TEST(Mjcf, EqualitiesAreJointsAndCouplings) {
  const Scene scene =
      read_model(model("<body name=\"a\"><joint name=\"ja\" axis=\"0 1 0\"/><inertial pos=\"0 0 0.5\" " + solid +
                           "/></body>\n"
                           "<body name=\"b\" pos=\"1 0 0\"><joint name=\"jb\" axis=\"0 1 0\"/><inertial pos=\"0 0 0.5\" " +
                           solid +
                           "/></body>\n"
                           "<body name=\"c\" pos=\"0 0 3\"><freejoint/><inertial pos=\"0 0 0\" " +
                           solid + "/></body>\n",
                       "",
                       "<equality><connect body1=\"a\" body2=\"b\" anchor=\"0.5 0 1\"/><weld name=\"w\" body1=\"c\"/>\n"
                       "<joint joint1=\"jb\" joint2=\"ja\" polycoef=\"0.1 2 0 0 0\"/><joint joint1=\"ja\" polycoef=\"0 1 1 0 "
                       "0\"/></equality>\n"),
                 ", joints: [{name: ja, at: 10}]");
  ASSERT_EQ(scene.joints.size(), 4U);
  EXPECT_EQ(scene.joints[2].kind, JointKind::ball);
  EXPECT_LT((scene.joints[2].anchor[0] - Vec3(0.5, 0, 0.5)).norm(), 1e-14);  // from a's centre
  EXPECT_EQ(scene.joints[3].kind, JointKind::fixed);
  EXPECT_EQ(scene.joints[3].ids[1], -1);
  ASSERT_EQ(scene.couplings.size(), 1U);
  EXPECT_EQ(scene.couplings[0].ratio, 2);
  const double b = 20 * M_PI / 180 + 0.1;
  EXPECT_LT((scene.body(1).state.position - Vec3(1 + 0.5 * std::sin(b), 0, 0.5 * std::cos(b))).norm(), 1e-14);
  ASSERT_EQ(scene.notes.size(), 1U);
  EXPECT_NE(scene.notes[0].find("left out equality joint of another form (1)"), std::string::npos) << scene.notes[0];
}

// Position and velocity actuators that have a largest force are motors, the entry's own motors go before them, and the rest is
// told.
TEST(Mjcf, ActuatorsAreMotors) {
  std::string world;
  for (const char* name : {"p", "v", "f", "o"})
    world += "<body><joint name=\"" + std::string(name) + "\" ref=\"10\"/><inertial pos=\"0.1 0 0\" " + solid + "/></body>\n";
  const Scene scene = read_model(
      model(
          world + "<geom type=\"plane\" size=\"1 1 1\"/><site/>\n", "<option timestep=\"0.001\"/>",
          "<actuator><position joint=\"p\" kp=\"9\" forcerange=\"-3 5\" gear=\"2\"/><velocity joint=\"v\" forcerange=\"-4 4\"/>\n"
          "<motor joint=\"f\"/><position joint=\"o\"/></actuator>\n"),
      ", joints: [{name: o, motor: {speed: 1, max_torque: 7}}]");
  ASSERT_EQ(scene.joints.size(), 4U);
  EXPECT_EQ(scene.joints[0].motor, Motor::position);
  EXPECT_EQ(scene.joints[0].strength.at(0), 10);
  EXPECT_NEAR(scene.joints[0].target.at(0), -10 * M_PI / 180, 1e-15);
  EXPECT_EQ(scene.joints[1].motor, Motor::speed);
  EXPECT_EQ(scene.joints[1].strength.at(0), 4);
  EXPECT_EQ(scene.joints[2].motor, Motor::none);
  EXPECT_EQ(scene.joints[3].strength.at(0), 7);
  ASSERT_EQ(scene.notes.size(), 1U);
  EXPECT_NE(scene.notes[0].find("left out actuator motor (1), actuator position without forcerange (1), option (1), plane of the "
                                "world (1)"),
            std::string::npos)
      << scene.notes[0];
}

// What stands in the world by itself is held; others lie on it.
TEST(Mjcf, TheWorldsGeomsAreHeld) {
  small_worlds::Experiment run(
      read_model(model("<geom type=\"box\" size=\"1 1 0.1\"/><body pos=\"0 0 0.5\"><freejoint/><geom size=\"0.2\"/></body>\n"),
                 ", self_collision: true"));
  run.seconds(1);
  EXPECT_EQ(run.position(0), Vec3(0, 0, 0));
  EXPECT_NEAR(run.position(1).z(), 0.3, 1e-4);
}

// A rod on a hinge moves as the same rod from a URDF file.
TEST(Mjcf, MovesAsTheSameRobotOfAUrdfFile) {
  const TextFile urdf(
      "<robot name=\"r\"><link name=\"base\"/><link name=\"rod\"><inertial><origin xyz=\"0 0 -0.5\"/><mass value=\"2\"/><inertia "
      "ixx=\"0.17\" iyy=\"0.17\" izz=\"0.01\"/></inertial></link><joint name=\"pivot\" type=\"continuous\"><parent "
      "link=\"base\"/>"
      "<child link=\"rod\"/><axis xyz=\"0 1 0\"/><dynamics damping=\"0.1\"/></joint></robot>\n",
      ".urdf");
  const TextFile mjcf(model("<body name=\"rod\"><joint name=\"pivot\" axis=\"0 1 0\" damping=\"0.1\"/><inertial pos=\"0 0 -0.5\" "
                            "mass=\"2\" diaginertia=\"0.17 0.17 0.01\"/></body>\n"),
                      ".xml");
  const auto name = [](const TextFile& file) { return file.path().substr(file.path().rfind('/') + 1); };
  const std::string joints =
      ", joints: [{name: pivot, at: 60}]}}\nsolver: {iterations: 100, tolerance: 0}\ntime: {frame: 0.002}\n";
  small_worlds::Experiment a(scene_from("bodies:\n  - {name: r, urdf: {file: " + name(urdf) + joints));
  small_worlds::Experiment b(scene_from("bodies:\n  - {name: r, mjcf: {file: " + name(mjcf) + joints));
  for (int k = 0; k < 200; ++k) {
    a.step(), b.step();
    ASSERT_LT((a.position(1) - b.position(0)).norm(), 1e-6) << k;
  }
}

namespace {

struct Fault {
  const char* name;
  std::string text, message;
};
void PrintTo(const Fault& fault, std::ostream* out) { *out << fault.name; }

class MjcfRefuses : public testing::TestWithParam<Fault> {};

std::string body(const std::string& inside) { return model("<body name=\"b\">" + inside + "</body>\n"); }
const std::string good = "<inertial pos=\"0 0 0\" " + solid + "/>";

const std::vector<Fault> faults{
    {"no_model", "<robot/>\n", "1: found <robot>, expected <mujoco>"},
    {"no_class", body("<freejoint/><geom class=\"c\" size=\"1\"/>"),
     "3: found class 'c', which no <default> has, expected the class of a <default>"},
    {"no_size", body("<freejoint/><geom type=\"box\" size=\"1 1\"/>"), "3: found size '1 1', expected 3 numbers > 0"},
    {"no_number", body("<freejoint/><geom size=\"1 x\"/>"), "3: found size '1 x', expected 1 to 3 numbers"},
    {"a_plane_that_moves", body("<freejoint/><geom type=\"plane\" size=\"1 1 1\"/>"),
     "3: found type 'plane', expected sphere, capsule, ellipsoid, cylinder, box or mesh"},
    {"no_mesh", body("<freejoint/><geom type=\"mesh\" mesh=\"k\"/>"),
     "3: found mesh 'k', expected the name of a mesh of <asset>"},
    {"a_mesh_of_another_type", body("<freejoint/><geom mesh=\"k\" size=\"1\"/>"),
     "3: found mesh 'k', expected type mesh with it"},
    {"no_mass", body("<joint/><geom size=\"1\" mass=\"0\"/>"),
     "3: found link 'b' without <inertial>, nor one of what is fixed to it, expected a mass and an inertia, since it moves"},
    {"free_within", body("<freejoint/>" + good + "<body><freejoint/>" + good + "</body>"),
     "3: found a free joint in a body of another, expected one in a body of the world"},
    {"free_and_more", body("<freejoint/><joint/>" + good),
     "3: found a body with a free joint and others, expected the free joint alone"},
    {"two_names", body("<joint name=\"j\"/>" + good + "<body><joint name=\"j\"/>" + good + "</body>"),
     "3: found a second joint 'j', expected another name"},
    {"limits", body("<joint range=\"20 10\"/>" + good), "3: found range '20 10', expected the lower limit first"},
    {"no_inertia", body("<freejoint/><inertial pos=\"0 0 0\" mass=\"1\"/>"),
     "3: found <inertial> without diaginertia and fullinertia, expected one of the two"},
    {"no_include", model("<include file=\"none.xml\"/>\n"),
     "3: found 'none.xml', which isn't at FOLDER/none.xml, expected a file that is there"},
    {"no_body", model("<body name=\"b\"><freejoint/>" + good + "</body>\n", "", "<equality><weld body1=\"c\"/></equality>\n"),
     "5: found body1 'c', expected the name of a body"},
    {"empty", model("<geom type=\"plane\" size=\"1 1 1\"/>\n"), "2: found no body in <worldbody>, expected one"},
};

TEST_P(MjcfRefuses, WithThisMessage) {
  const TextFile file(GetParam().text, ".xml");
  std::string expected = file.path() + ":" + GetParam().message;
  const std::string folder = file.path().substr(0, file.path().rfind('/'));
  if (const auto at = expected.find("FOLDER"); at != std::string::npos) expected.replace(at, 6, folder);
  try {
    scene_from(entry(file));
    ADD_FAILURE() << "it is read";
  } catch (const InputError& error) {
    EXPECT_EQ(std::string(error.what()), expected);
  }
}

INSTANTIATE_TEST_SUITE_P(Faults, MjcfRefuses, testing::ValuesIn(faults), [](const auto& each) { return each.param.name; });

}  // namespace

}  // namespace unibody::mjcf_test
