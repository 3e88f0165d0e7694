// Models beside MuJoCo, whose format MJCF is: masses, centres, inertia matrices and places of bodies as it reads them, and motion
// that becomes its own as steps become short.
#include <gtest/gtest.h>

#ifdef UNIBODY_HAS_MUJOCO
#include <mujoco/mujoco.h>

#include <cmath>
#include <fstream>
#include <map>

#include "scene/scene_text.hpp"
#include "small_worlds.hpp"

namespace unibody::mujoco_test {
namespace {

using Angles = std::map<std::string, double>;  // degrees or m, of joints by their names

// A model as MuJoCo has read it, with its joints at these places.
class Peer {
 public:
  Peer(const std::string& path, const Angles& at) {
    std::array<char, 1000> fault{};
    model_ = mj_loadXML(path.c_str(), nullptr, fault.data(), fault.size());
    if (model_ == nullptr) throw std::runtime_error(fault.data());
    data_ = mj_makeData(model_);
    for (const auto& [name, value] : at) {
      const int joint = mj_name2id(model_, mjOBJ_JOINT, name.c_str());
      if (joint < 0) throw std::runtime_error("no joint " + name);
      const bool slides = model_->jnt_type[joint] == mjJNT_SLIDE;
      data_->qpos[model_->jnt_qposadr[joint]] += slides ? value : value * M_PI / 180;
    }
    mj_forward(model_, data_);
  }
  ~Peer() { mj_deleteData(data_), mj_deleteModel(model_); }
  Peer(const Peer&) = delete;
  Peer& operator=(const Peer&) = delete;

  int number(const std::string& body) const { return mj_name2id(model_, mjOBJ_BODY, body.c_str()); }
  double mass(int body) const { return model_->body_mass[body]; }
  Vec3 centre(int body) const { return Eigen::Map<const Vec3>(data_->xipos + 3 * body); }
  Mat3 inertia(int body) const {  // about the centre, in the world's axes
    const Mat3 axes = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(data_->ximat + 9 * body);
    return axes * Eigen::Map<const Vec3>(model_->body_inertia + 3 * body).asDiagonal() * axes.transpose();
  }
  void run(double seconds, double step) {
    model_->opt.timestep = step, model_->opt.integrator = mjINT_RK4;
    for (int k = 0; k < std::lround(seconds / step); ++k) mj_step(model_, data_);
    mj_kinematics(model_, data_);
  }

 private:
  mjModel* model_ = nullptr;
  mjData* data_ = nullptr;
};

Scene scene_of(const std::string& generator, const std::string& path, const Angles& at, const std::string& more = "") {
  std::string joints;
  for (const auto& [name, value] : at)
    joints += (joints.empty() ? "" : ", ") + ("{name: " + name + ", at: " + std::to_string(value) + "}");
  if (!joints.empty()) joints = ", joints: [" + joints + "]";
  return scene_from("bodies: [{name: m, " + generator + ": {file: " + path + joints + "}}]\n" + more);
}

Mat3 inertia_of(const Body& body) {
  const Mat3 axes = body.state.orientation.toRotationMatrix();
  return axes * body.properties.inertia.asDiagonal() * axes.transpose();
}

// Every body of the scene is one of MuJoCo's.
void expect_same_bodies(const Scene& scene, const Peer& peer) {
  for (Id k = 0; k < scene.body_count(); ++k) {
    const Body body = scene.body(k);
    const std::string name = scene.body_name(k).substr(2);
    const int number = peer.number(name);
    ASSERT_GE(number, 0) << name;
    EXPECT_NEAR(body.properties.mass, peer.mass(number), 1e-9 * body.properties.mass) << name;
    EXPECT_LT((body.state.position - peer.centre(number)).norm(), 1e-8) << name;
    EXPECT_LT((inertia_of(body) - peer.inertia(number)).norm(), 1e-8 * peer.inertia(number).norm()) << name;
  }
}

std::string model(const std::string& before, const std::string& world) {
  return "<mujoco>\n" + before + "<worldbody>\n" + world + "</worldbody>\n</mujoco>\n";
}

// Turns said in many ways, shapes of every kind that has a closed form, classes in classes.
const std::string of_everything = model(
    "<compiler eulerseq=\"zyx\" autolimits=\"true\"/>\n<default><geom density=\"700\"/><default class=\"arm\"><joint axis=\"1 2 "
    "0\" "
    "pos=\"0.1 0 0.05\"/><geom type=\"capsule\" size=\"0.04\" fromto=\"0 0 0 0.2 0.1 0.3\"/><default class=\"heavy\"><geom "
    "density=\"2500\"/></default></default></default>\n",
    "<body name=\"base\" pos=\"0.1 0.2 1\" euler=\"20 30 40\"><joint name=\"turn\" axis=\"0 0 1\"/>\n"
    "<geom type=\"box\" size=\"0.1 0.2 0.05\" axisangle=\"1 0 1 25\"/><geom type=\"cylinder\" size=\"0.06 0.2\" pos=\"0 0.1 "
    "0\"/>\n"
    "<body name=\"arm\" pos=\"0.3 0 0\" quat=\"0.9 0.1 -0.3 0.2\" childclass=\"arm\"><joint name=\"lift\" range=\"-90 90\"/>\n"
    "<geom/><geom class=\"heavy\" fromto=\"0 0 0 0 0 -0.2\"/>\n"
    "<body name=\"slide\" pos=\"0 0.1 0.2\" xyaxes=\"0 1 0 -1 0 0.5\"><joint name=\"out\" type=\"slide\" axis=\"0 1 1\"/>\n"
    "<geom class=\"main\" type=\"sphere\" size=\"0.07\"/></body></body></body>\n"
    "<body name=\"free\" pos=\"0 0 3\" zaxis=\"1 2 3\"><freejoint/><geom type=\"ellipsoid\" size=\"0.1 0.2 0.3\" mass=\"2\"/>\n"
    "<inertial pos=\"0.1 0.2 0.3\" mass=\"3\" fullinertia=\"0.5 0.6 0.7 0.1 0.05 -0.1\"/></body>\n"
    "<body name=\"ball\" pos=\"2 0 0\"><joint type=\"ball\" pos=\"0 0 0.4\"/><geom type=\"box\" size=\"0.1 0.1 0.3\"/></body>\n");

}  // namespace

TEST(Mujoco, BodiesAreThoseItReads) {
  for (const Angles& at : {Angles{}, Angles{{"turn", 35}, {"lift", -50}, {"out", 0.12}}}) {
    const TextFile file(of_everything, ".xml");
    const Scene scene = scene_of("mjcf", file.path(), at);
    ASSERT_EQ(scene.body_count(), 5);
    expect_same_bodies(scene, Peer(file.path(), at));
  }
}

TEST(Mujoco, TheQuadrupedIsTheOneItReads) {
  const std::string path = std::string(UNIBODY_SOURCE_DIR) + "/scenes/robots/quadruped.xml";
  const Angles at{{"front_left_hip", 20}, {"front_left_knee", -40}, {"rear_right_hip", -10}, {"rear_right_knee", -5}};
  const Scene scene = scene_of("mjcf", path, at);
  ASSERT_EQ(scene.body_count(), 9);
  expect_same_bodies(scene, Peer(path, at));
}

// A URDF file, which MuJoCo reads too, where all products of inertia are said.
TEST(Mujoco, TheRobotArmIsTheOneItReads) {
  std::ifstream arm(std::string(UNIBODY_SOURCE_DIR) + "/scenes/robots/arm.urdf");
  std::string text{std::istreambuf_iterator<char>(arm), {}};
  for (std::size_t at = text.find(" izz="); at != std::string::npos; at = text.find(" izz=", at + 40))
    text.insert(at, " ixy=\"0\" ixz=\"0\" iyz=\"0\"");
  const TextFile file(text, ".urdf");
  const std::string& path = file.path();
  const Angles at{{"turn", 30}, {"shoulder", 25}, {"elbow", 70}, {"wrist", 20}};
  const Scene scene = scene_of("urdf", path, at);
  const Peer peer(path, at);
  int compared = 0;
  for (Id k = 0; k < scene.body_count(); ++k) {
    const int number = peer.number(scene.body_name(k).substr(2));
    if (number < 0) continue;  // its root, the world there
    EXPECT_LT((scene.body(k).state.position - peer.centre(number)).norm(), 1e-8) << scene.body_name(k);
    ++compared;
  }
  EXPECT_GE(compared, 4);
}

// An arm of a hinge, a slider on a spring and a hinge, with damping, let go: the shorter the step, the nearer to MuJoCo's motion.
TEST(Mujoco, MotionComesToItsOwn) {
  const TextFile file(
      model("<option/>",
            "<body name=\"a\" pos=\"0 0 2\"><joint name=\"one\" axis=\"0 1 0\" damping=\"0.2\"/><geom type=\"box\" size=\"0.05 "
            "0.05 0.2\" "
            "pos=\"0.1 0 -0.2\" contype=\"0\" conaffinity=\"0\"/>\n<body name=\"b\" pos=\"0 0 -0.4\"><joint name=\"two\" "
            "type=\"slide\" "
            "axis=\"0 0 1\" stiffness=\"900\" damping=\"3\" springref=\"0.05\"/><geom type=\"sphere\" size=\"0.1\" contype=\"0\" "
            "conaffinity=\"0\"/>\n<body name=\"c\" pos=\"0 0 -0.2\"><joint name=\"three\" axis=\"1 0 0\"/><geom type=\"capsule\" "
            "size=\"0.04\" fromto=\"0 0 0 0.1 0 -0.3\" contype=\"0\" conaffinity=\"0\"/></body></body></body>\n"),
      ".xml");
  const Angles at{{"one", 50}, {"three", 40}};
  constexpr double seconds = 0.5;
  Peer peer(file.path(), at);
  peer.run(seconds, 1e-4);
  std::vector<double> errors;
  for (const double step : {0.002, 0.001, 0.0005}) {
    small_worlds::Experiment run(
        scene_of("mjcf", file.path(), at, "solver: {joints: direct}\ntime: {frame: " + std::to_string(step) + "}\n"));
    run.seconds(seconds);
    double error = 0;
    for (Id k = 0; k < 3; ++k) error = std::max(error, (run.position(k) - peer.centre(static_cast<int>(k) + 1)).norm());
    errors.push_back(error);
  }
  EXPECT_LT(errors[1], 0.6 * errors[0]);
  EXPECT_LT(errors[2], 0.6 * errors[1]);
  EXPECT_LT(errors[2], 2e-3);
}

}  // namespace unibody::mujoco_test

#else

TEST(Mujoco, IsNotHere) { GTEST_SKIP() << "built without MuJoCo"; }

#endif
