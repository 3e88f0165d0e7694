#include "scene/urdf_file.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <map>
#include <pugixml.hpp>
#include <sstream>

#include "core/text.hpp"
#include "meshes/mesh_file.hpp"

namespace unibody {

namespace {

using pugi::xml_node;

class Reader {
 public:
  explicit Reader(const std::string& path) : path_(path), bytes_(read_bytes(path, "a robot (URDF)")) {}

  Urdf read() {
    const pugi::xml_parse_result result =
        document_.load_buffer(bytes_.data(), bytes_.size(), pugi::parse_minimal, pugi::encoding_utf8);
    if (!result)
      fail_at(path_, line_at(static_cast<std::size_t>(result.offset)), "bad XML (" + std::string(result.description()) + ")",
              "a robot (URDF)");
    const xml_node robot = document_.child("robot");
    if (!robot) fail(document_.first_child(), "<" + std::string(document_.first_child().name()) + ">", "<robot>");
    urdf_.name = robot.attribute("name").value();
    for (const xml_node node : robot.children())
      if (std::string_view(node.name()).starts_with("xacro:"))
        fail(node, "<" + std::string(node.name()) + ">", "a robot without macros, as the program xacro makes one");
    for (const xml_node node : robot.children("link")) read_link(node);
    for (const xml_node node : robot.children("joint")) read_joint(node);
    find_root(robot);
    check_mimics();
    count_unused(robot, {"link", "joint", "material"});
    for (const auto& [name, count] : unused_)
      urdf_.unused += (urdf_.unused.empty() ? "" : ", ") + name + " (" + std::to_string(count) + ")";
    return std::move(urdf_);
  }

 private:
  std::int64_t line_at(std::size_t offset) const {
    return 1 + std::count(bytes_.begin(), bytes_.begin() + static_cast<std::ptrdiff_t>(std::min(offset, bytes_.size())), '\n');
  }
  std::int64_t line_of(const xml_node& node) const {
    return line_at(static_cast<std::size_t>(std::max<std::ptrdiff_t>(0, node.offset_debug())));
  }
  [[noreturn]] void fail(const xml_node& node, const std::string& found, const std::string& expected) const {
    fail_at(path_, line_of(node), found, expected);
  }

  // Elements of these names are read; the others are counted.
  void count_unused(const xml_node& node, const std::vector<std::string>& used) {
    for (const xml_node child : node.children())
      if (child.type() == pugi::node_element && std::ranges::find(used, child.name()) == used.end()) ++unused_[child.name()];
  }

  std::string text(const xml_node& node, const char* name) const {
    const pugi::xml_attribute found = node.attribute(name);
    if (!found) fail(node, "<" + std::string(node.name()) + "> without " + name, "one");
    return found.value();
  }
  xml_node child(const xml_node& node, const char* name) const {
    const xml_node found = node.child(name);
    if (!found) fail(node, "no <" + std::string(name) + "> in <" + node.name() + ">", "one");
    return found;
  }
  std::vector<double> numbers(const xml_node& node, const char* name, std::size_t count) const {
    const std::string all = text(node, name);
    std::istringstream words(all);
    std::vector<double> values;
    for (std::string word; words >> word;) {
      double value = 0;
      if (!parse(std::string_view(word), value) || !std::isfinite(value)) break;
      values.push_back(value);
    }
    std::string word;
    if (values.size() != count || !words.eof() || words >> word)
      fail(node, std::string(name) + " " + quote(all), count == 1 ? "a number" : std::to_string(count) + " numbers");
    return values;
  }
  double number(const xml_node& node, const char* name) const { return numbers(node, name, 1)[0]; }
  double number(const xml_node& node, const char* name, double without) const {
    return node.attribute(name) ? number(node, name) : without;
  }
  double positive(const xml_node& node, const char* name) const {
    const double value = number(node, name);
    if (!(value > 0)) fail(node, std::string(name) + " " + quote(text(node, name)), "a number > 0");
    return value;
  }
  double not_negative(const xml_node& node, const char* name) const {
    const double value = number(node, name, 0);
    if (!(value >= 0)) fail(node, std::string(name) + " " + quote(text(node, name)), "a number >= 0");
    return value;
  }
  Vec3 vector(const xml_node& node, const char* name) const {
    const std::vector<double> v = numbers(node, name, 3);
    return {v[0], v[1], v[2]};
  }

  // <origin xyz rpy>: turns about the fixed axes x, y and z, one after the other.
  Pose read_origin(const xml_node& of) const {
    const xml_node origin = of.child("origin");
    Pose pose;
    if (origin.attribute("xyz")) pose.at = vector(origin, "xyz");
    if (origin.attribute("rpy")) {
      const Vec3 a = vector(origin, "rpy");
      pose.turn = Quat(Eigen::AngleAxisd(a[2], Vec3::UnitZ())) * Quat(Eigen::AngleAxisd(a[1], Vec3::UnitY())) *
                  Quat(Eigen::AngleAxisd(a[0], Vec3::UnitX()));
    }
    return pose;
  }

  void read_link(const xml_node& node) {
    UrdfLink link;
    link.name = text(node, "name"), link.line = line_of(node);
    if (std::ranges::find(urdf_.links, link.name, &UrdfLink::name) != urdf_.links.end())
      fail(node, "a second link " + quote(link.name), "another name");
    if (const xml_node inertial = node.child("inertial")) read_inertial(inertial, link);
    for (const xml_node collision : node.children("collision")) link.collisions.push_back(read_collision(collision));
    count_unused(node, {"inertial", "collision", "visual"});
    urdf_.links.push_back(std::move(link));
  }

  void read_inertial(const xml_node& node, UrdfLink& link) const {
    link.centre = read_origin(node);
    const xml_node mass = child(node, "mass"), inertia = child(node, "inertia");
    link.mass = positive(mass, "value");
    const auto of = [&](const char* name) { return number(inertia, name, 0); };
    for (const char* name : {"ixx", "iyy", "izz"}) positive(inertia, name);
    link.inertia << of("ixx"), of("ixy"), of("ixz"), of("ixy"), of("iyy"), of("iyz"), of("ixz"), of("iyz"), of("izz");
    if (!(Eigen::SelfAdjointEigenSolver<Mat3>(link.inertia, Eigen::EigenvaluesOnly).eigenvalues().minCoeff() > 0))
      fail(inertia, "moments of inertia that are not all > 0 about their principal axes", "those of a solid");
  }

  UrdfCollision read_collision(const xml_node& node) const {
    UrdfCollision collision;
    collision.pose = read_origin(node), collision.line = line_of(node);
    const xml_node geometry = child(node, "geometry"), shape = geometry.first_child();
    const std::string kind = shape.name();
    if (kind == "box") {
      collision.kind = UrdfCollision::Kind::box, collision.size = vector(shape, "size");
      if (!(collision.size.minCoeff() > 0)) fail(shape, "size " + quote(text(shape, "size")), "3 numbers > 0");
    } else if (kind == "cylinder") {
      collision.kind = UrdfCollision::Kind::cylinder, collision.size = {positive(shape, "radius"), positive(shape, "length"), 0};
    } else if (kind == "sphere") {
      collision.kind = UrdfCollision::Kind::sphere, collision.size = {positive(shape, "radius"), 0, 0};
    } else if (kind == "mesh") {
      collision.kind = UrdfCollision::Kind::mesh, collision.file = text(shape, "filename");
      collision.size = shape.attribute("scale") ? vector(shape, "scale") : Vec3(Vec3::Ones());
    } else {
      fail(geometry, "<geometry> with " + (kind.empty() ? "nothing" : "<" + kind + ">"), "box, cylinder, sphere or mesh");
    }
    return collision;
  }

  std::size_t read_link_name(const xml_node& node) const {
    const std::string name = text(node, "link");
    const auto found = std::ranges::find(urdf_.links, name, &UrdfLink::name);
    if (found == urdf_.links.end()) fail(node, quote(name) + ", a name that no link has", "the name of a link");
    return static_cast<std::size_t>(found - urdf_.links.begin());
  }

  void read_joint(const xml_node& node) {
    UrdfJoint joint;
    joint.name = text(node, "name"), joint.line = line_of(node);
    if (std::ranges::find(urdf_.joints, joint.name, &UrdfJoint::name) != urdf_.joints.end())
      fail(node, "a second joint " + quote(joint.name), "another name");
    static const std::vector<std::string> kinds{"fixed", "revolute", "continuous", "prismatic", "floating"};
    const auto kind = std::ranges::find(kinds, text(node, "type"));
    if (kind == kinds.end()) fail(node, "a joint of type " + quote(text(node, "type")), one_of(kinds));
    joint.kind = static_cast<UrdfJoint::Kind>(kind - kinds.begin());
    joint.parent = read_link_name(child(node, "parent")), joint.child = read_link_name(child(node, "child"));
    joint.pose = read_origin(node);
    if (joint.moves()) read_motion(node, joint);
    count_unused(node, {"origin", "parent", "child", "axis", "limit", "dynamics", "mimic"});
    urdf_.joints.push_back(std::move(joint));
  }

  void read_motion(const xml_node& node, UrdfJoint& joint) {
    if (const xml_node axis = node.child("axis")) {
      joint.axis = vector(axis, "xyz");
      if (!(joint.axis.norm() > 0)) fail(axis, "xyz " + quote(text(axis, "xyz")), "a vector that is not 0");
      joint.axis.normalize();
    }
    const xml_node limit = node.child("limit");
    if (joint.kind != UrdfJoint::Kind::continuous) {
      if (!limit) fail(node, "no <limit> in a " + std::string(node.attribute("type").value()) + " joint", "one");
      joint.lower = number(limit, "lower", 0), joint.upper = number(limit, "upper", 0);
      if (joint.lower > joint.upper) fail(limit, "a lower limit above the upper", "the lower limit first");
    }
    for (const char* name : {"effort", "velocity"})
      if (limit.attribute(name)) ++unused_["limit " + std::string(name)];
    if (const xml_node dynamics = node.child("dynamics"))
      joint.damping = not_negative(dynamics, "damping"), joint.friction = not_negative(dynamics, "friction");
    if (const xml_node mimic = node.child("mimic"))
      joint.mimic = UrdfMimic{text(mimic, "joint"), number(mimic, "multiplier", 1), number(mimic, "offset", 0)};
  }

  void find_root(const xml_node& robot) {
    std::vector<int> parents(urdf_.links.size(), 0);
    for (const UrdfJoint& joint : urdf_.joints)
      if (++parents[joint.child] > 1)
        fail_at(path_, joint.line, "a second joint above link " + quote(urdf_.links[joint.child].name), "one");
    const auto roots = std::ranges::count(parents, 0);
    if (roots != 1)
      fail(robot, std::to_string(roots) + " links that are nobody's child", "one, from which joints lead to all others");
    urdf_.root = static_cast<std::size_t>(std::ranges::find(parents, 0) - parents.begin());
    if (urdf_.joints.size() + 1 != urdf_.links.size()) fail(robot, "joints that form a loop", "a tree");
    std::size_t reached = 1;  // the root, and what joints lead to from it
    std::vector<std::size_t> open{urdf_.root};
    while (!open.empty()) {
      const std::size_t link = open.back();
      open.pop_back();
      for (const UrdfJoint& joint : urdf_.joints)
        if (joint.parent == link) ++reached, open.push_back(joint.child);
    }
    if (reached != urdf_.links.size()) fail(robot, "joints that form a loop", "a tree");
  }

  void check_mimics() const {
    for (const UrdfJoint& joint : urdf_.joints) {
      if (!joint.mimic) continue;
      const auto other = std::ranges::find(urdf_.joints, joint.mimic->joint, &UrdfJoint::name);
      if (other == urdf_.joints.end() || !other->moves() || other->mimic || joint.mimic->multiplier == 0)
        fail_at(path_, joint.line, "joint " + quote(joint.name) + " that mimics " + quote(joint.mimic->joint),
                "the name of another joint that moves by itself, and a multiplier other than 0");
    }
  }

  const std::string& path_;
  const std::string bytes_;
  pugi::xml_document document_;
  Urdf urdf_;
  std::map<std::string, int> unused_;
};

}  // namespace

Urdf read_urdf(const std::string& path) { return Reader(path).read(); }

}  // namespace unibody
