#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <map>

#include "core/text.hpp"
#include "meshes/mesh_file.hpp"
#include "scene/joints.hpp"
#include "scene/robot_model.hpp"
#include "scene/xml_file.hpp"

namespace unibody {

namespace {

using pugi::xml_node;

// The Unified Robot Description Format of ROS.
class UrdfReader {
 public:
  explicit UrdfReader(const std::string& path) : xml_(path, "a robot (URDF)") {}

  RobotModel read() {
    const xml_node robot = xml_.document().child("robot"), first = xml_.document().first_child();
    if (!robot) xml_.fail(first, "<" + std::string(first.name()) + ">", "<robot>");
    for (const xml_node node : robot.children())
      if (std::string_view(node.name()).starts_with("xacro:"))
        xml_.fail(node, "<" + std::string(node.name()) + ">", "a robot without macros, as the program xacro makes one");
    for (const xml_node node : robot.children("link")) read_link(node);
    for (const xml_node node : robot.children("joint")) read_joint(node);
    find_root(robot);
    check_mimics();
    count_unused(robot, {"link", "joint", "material"});
    for (const auto& [name, count] : unused_)
      model_.unused += (model_.unused.empty() ? "" : ", ") + name + " (" + std::to_string(count) + ")";
    return std::move(model_);
  }

 private:
  // Elements of these names are read; the others are counted.
  void count_unused(const xml_node& node, const std::vector<std::string>& used) {
    for (const xml_node child : node.children())
      if (child.type() == pugi::node_element && std::ranges::find(used, child.name()) == used.end()) ++unused_[child.name()];
  }

  // <origin xyz rpy>: turns about the fixed axes x, y and z, one after the other.
  Pose read_origin(const xml_node& of) const {
    const xml_node origin = of.child("origin");
    Pose pose;
    if (origin.attribute("xyz")) pose.at = xml_.vector(origin, "xyz");
    if (origin.attribute("rpy")) {
      const Vec3 a = xml_.vector(origin, "rpy");
      pose.turn = Quat(Eigen::AngleAxisd(a[2], Vec3::UnitZ())) * Quat(Eigen::AngleAxisd(a[1], Vec3::UnitY())) *
                  Quat(Eigen::AngleAxisd(a[0], Vec3::UnitX()));
    }
    return pose;
  }

  void read_link(const xml_node& node) {
    RobotLink link;
    link.name = xml_.text(node, "name"), link.line = xml_.line_of(node);
    if (std::ranges::find(model_.links, link.name, &RobotLink::name) != model_.links.end())
      xml_.fail(node, "a second link " + quote(link.name), "another name");
    if (const xml_node inertial = node.child("inertial")) read_inertial(inertial, link);
    for (const xml_node collision : node.children("collision")) link.shapes.push_back(read_collision(collision));
    count_unused(node, {"inertial", "collision", "visual"});
    model_.links.push_back(std::move(link));
  }

  void read_inertial(const xml_node& node, RobotLink& link) const {
    link.centre = read_origin(node);
    const xml_node mass = xml_.child(node, "mass"), inertia = xml_.child(node, "inertia");
    link.mass = xml_.positive(mass, "value");
    const auto of = [&](const char* name) { return xml_.number(inertia, name, 0); };
    for (const char* name : {"ixx", "iyy", "izz"}) xml_.positive(inertia, name);
    link.inertia << of("ixx"), of("ixy"), of("ixz"), of("ixy"), of("iyy"), of("iyz"), of("ixz"), of("iyz"), of("izz");
    if (!(Eigen::SelfAdjointEigenSolver<Mat3>(link.inertia, Eigen::EigenvaluesOnly).eigenvalues().minCoeff() > 0))
      xml_.fail(inertia, "moments of inertia that are not all > 0 about their principal axes", "those of a solid");
  }

  RobotShape read_collision(const xml_node& node) const {
    RobotShape collision;
    collision.pose = read_origin(node), collision.line = xml_.line_of(node);
    const xml_node geometry = xml_.child(node, "geometry"), shape = geometry.first_child();
    const std::string kind = shape.name();
    if (kind == "box") {
      collision.kind = RobotShape::Kind::box, collision.size = xml_.vector(shape, "size");
      if (!(collision.size.minCoeff() > 0)) xml_.fail(shape, "size " + quote(xml_.text(shape, "size")), "3 numbers > 0");
    } else if (kind == "cylinder") {
      collision.kind = RobotShape::Kind::cylinder,
      collision.size = {xml_.positive(shape, "radius"), xml_.positive(shape, "length"), 0};
    } else if (kind == "sphere") {
      collision.kind = RobotShape::Kind::sphere, collision.size = {xml_.positive(shape, "radius"), 0, 0};
    } else if (kind == "mesh") {
      collision.kind = RobotShape::Kind::mesh, collision.file = xml_.text(shape, "filename");
      collision.size = shape.attribute("scale") ? xml_.vector(shape, "scale") : Vec3(Vec3::Ones());
    } else {
      xml_.fail(geometry, "<geometry> with " + (kind.empty() ? "nothing" : "<" + kind + ">"), "box, cylinder, sphere or mesh");
    }
    return collision;
  }

  std::size_t read_link_name(const xml_node& node) const {
    const std::string name = xml_.text(node, "link");
    const auto found = std::ranges::find(model_.links, name, &RobotLink::name);
    if (found == model_.links.end()) xml_.fail(node, quote(name) + ", a name that no link has", "the name of a link");
    return static_cast<std::size_t>(found - model_.links.begin());
  }

  void read_joint(const xml_node& node) {
    RobotJoint joint;
    joint.name = xml_.text(node, "name"), joint.line = xml_.line_of(node);
    if (std::ranges::find(model_.joints, joint.name, &RobotJoint::name) != model_.joints.end())
      xml_.fail(node, "a second joint " + quote(joint.name), "another name");
    using Kind = RobotJoint::Kind;
    static const std::vector<std::string> names{"fixed", "revolute", "continuous", "prismatic", "planar", "floating"};
    static constexpr std::array kinds{Kind::fixed,     Kind::revolute, Kind::revolute,
                                      Kind::prismatic, Kind::revolute, Kind::floating};
    const std::string type = xml_.text(node, "type");
    const auto place = std::ranges::find(names, type) - names.begin();
    if (place == std::ssize(names)) xml_.fail(node, "a joint of type " + quote(type), one_of(names));
    joint.kind = kinds[static_cast<std::size_t>(place)];
    joint.parent = read_link_name(xml_.child(node, "parent")), joint.child = read_link_name(xml_.child(node, "child"));
    joint.pose = read_origin(node);
    if (joint.has_coordinate()) read_motion(node, type, joint);
    count_unused(node, {"origin", "parent", "child", "axis", "limit", "dynamics", "mimic"});
    if (type == "planar") slide_first(joint);
    model_.joints.push_back(std::move(joint));
  }

  // A planar joint: its child turns about the axis on a link that slides along one direction across it, and that on one that
  // slides along the other.
  void slide_first(RobotJoint& joint) {
    const Mat3 axes = joint_axes(joint.axis).toRotationMatrix();
    for (int k = 0; k < 2; ++k) {
      const std::string letter = k == 0 ? "x" : "y";
      RobotJoint slider = joint;
      slider.name += "_" + letter, slider.kind = RobotJoint::Kind::prismatic, slider.axis = axes.col(k), slider.mimic = {};
      slider.child = model_.links.size();
      RobotLink between;
      between.name = model_.links[joint.child].name + "_" + letter, between.line = joint.line;
      between.between_joints_of = static_cast<std::int64_t>(joint.child);
      model_.links.push_back(std::move(between));
      joint.parent = slider.child, joint.pose = {};
      model_.joints.push_back(std::move(slider));
    }
    model_.notes.push_back("link " + model_.links[joint.child].name +
                           " has a planar joint: of its mass 1 % goes with each of two links "
                           "between; solver.joints: direct solves them to rounding");
  }

  void read_motion(const xml_node& node, const std::string& type, RobotJoint& joint) {
    if (const xml_node axis = node.child("axis")) {
      joint.axis = xml_.vector(axis, "xyz");
      if (!(joint.axis.norm() > 0)) xml_.fail(axis, "xyz " + quote(xml_.text(axis, "xyz")), "a vector that is not 0");
      joint.axis.normalize();
    }
    const xml_node limit = node.child("limit");
    if (type == "revolute" || type == "prismatic") {
      if (!limit) xml_.fail(node, "no <limit> in a " + type + " joint", "one");
      joint.lower = xml_.number(limit, "lower", 0), joint.upper = xml_.number(limit, "upper", 0);
      if (joint.lower > joint.upper) xml_.fail(limit, "a lower limit above the upper", "the lower limit first");
    }
    for (const char* name : {"effort", "velocity"})
      if (limit.attribute(name)) ++unused_["limit " + std::string(name)];
    if (const xml_node dynamics = node.child("dynamics"))
      joint.damping = xml_.not_negative(dynamics, "damping"), joint.friction = xml_.not_negative(dynamics, "friction");
    if (const xml_node mimic = node.child("mimic"))
      joint.mimic = RobotMimic{xml_.text(mimic, "joint"), xml_.number(mimic, "multiplier", 1), xml_.number(mimic, "offset", 0)};
  }

  void find_root(const xml_node& robot) {
    std::vector<int> parents(model_.links.size(), 0);
    for (const RobotJoint& joint : model_.joints)
      if (++parents[joint.child] > 1)
        fail_at(xml_.path(), joint.line, "a second joint above link " + quote(model_.links[joint.child].name), "one");
    const auto roots = std::ranges::count(parents, 0);
    if (roots != 1)
      xml_.fail(robot, std::to_string(roots) + " links that are nobody's child", "one, from which joints lead to all others");
    model_.root = static_cast<std::size_t>(std::ranges::find(parents, 0) - parents.begin());
    if (model_.joints.size() + 1 != model_.links.size()) xml_.fail(robot, "joints that form a loop", "a tree");
    std::size_t reached = 1;  // the root, and what joints lead to from it
    std::vector<std::size_t> open{model_.root};
    while (!open.empty()) {
      const std::size_t link = open.back();
      open.pop_back();
      for (const RobotJoint& joint : model_.joints)
        if (joint.parent == link) ++reached, open.push_back(joint.child);
    }
    if (reached != model_.links.size()) xml_.fail(robot, "joints that form a loop", "a tree");
  }

  void check_mimics() const {
    for (const RobotJoint& joint : model_.joints) {
      if (!joint.mimic) continue;
      const auto other = std::ranges::find(model_.joints, joint.mimic->joint, &RobotJoint::name);
      if (other == model_.joints.end() || !other->has_coordinate() || other->mimic || joint.mimic->multiplier == 0)
        fail_at(xml_.path(), joint.line, "joint " + quote(joint.name) + " that mimics " + quote(joint.mimic->joint),
                "the name of another joint that moves by itself, and a multiplier other than 0");
    }
  }

  const XmlFile xml_;
  RobotModel model_;
  std::map<std::string, int> unused_;
};

}  // namespace

RobotModel read_urdf(const std::string& path) { return UrdfReader(path).read(); }

}  // namespace unibody
