// The generators `urdf` and `mjcf`: the bodies and joints of a robot's file.
#include "scene/robot.hpp"

#include <algorithm>
#include <cmath>

#include "core/text.hpp"
#include "meshes/mesh_file.hpp"
#include "scene/articulated.hpp"
#include "scene/joint_keys.hpp"
#include "scene/joints.hpp"
#include "scene/robot_body.hpp"
#include "world/shape_library.hpp"

namespace unibody {

namespace {

constexpr double share_between_joints = 0.01;  // of a body's mass that goes with each link between two of its joints

const Keys& turning_motor_of_robot() { return motor_keys(true); }
const Keys& sliding_motor_of_robot() { return motor_keys(false); }

const Keys& robot_joint_keys() {
  static const Keys table{
      "robot_joint",
      "A joint of a robot: where it is at the start, and its motor.",
      {keys::text("name", "the name of a joint of the file", needed, "the joint"),
       keys::number("at", "degrees or m", any_number, 0, "angle or offset at the start"),
       keys::other(
           "motor", "", "a map", "none", "its motor, as of a hinge or slider",
           [] {
             return keys::any_of({keys::reference_to(turning_motor_of_robot), keys::reference_to(sliding_motor_of_robot)});
           },
           {turning_motor_of_robot, sliding_motor_of_robot})}};
  return table;
}

Key links_touch_key() {
  return keys::flag("self_collision", false, "its links may touch each other, but for those that a joint ties");
}
Key joints_key() {
  return keys::list_of_maps("joints", robot_joint_keys, "a list of joints of the file", "none",
                            "where joints are at the start, and their motors");
}

// A joint's own entry in the scene.
struct Wish {
  double at = 0;  // rad or m
  const Value* motor = nullptr;
};

// A joint of the file, between two bodies.
struct Tie {
  std::size_t joint, child, parent;
};

std::string path_of(const KeyedMap& map, const Scene& scene) {
  const Value& file = map.need("file");
  const auto path = std::filesystem::path(scene.path).parent_path() / file.string(map.key("file").words);
  if (scene.planar) file.fail_expected("no robot in a planar scene");
  return path.string();
}

class Robot {
 public:
  Robot(const KeyedMap& map, const Scene& scene, const RobotModel& model, const RobotFiles& files)
      : map_(map), scene_(scene), model_(model), files_(files) {
    read_wishes();
    place(model_.root, {}, {}, add_body(model_.root, {}, {}), {});
    for (std::size_t link = 0; link < model_.links.size(); ++link)
      if (const auto of = model_.links[link].between_joints_of; of >= 0)
        bodies_[body_of_[link]].take_share(share_between_joints, bodies_[body_of_[static_cast<std::size_t>(of)]]);
    has_root_ = !model_.root_is_world || !bodies_[0].parts.empty();
  }

  Generated generate(const BodyTemplate& common, bool is_held) {
    auto zeros = std::make_shared<std::vector<Body>>(), bodies = std::make_shared<std::vector<Body>>();
    Generated result;
    for (std::size_t b = 0; b < bodies_.size(); ++b) {
      add_root_mass(b, is_held);
      make(b, common, *zeros, *bodies);
      if (b == 0 && is_held) bodies->back().properties.motion = Motion::pinned;
    }
    const Id first = has_root_ ? 0 : 1;
    for (std::size_t b = static_cast<std::size_t>(first); b < bodies_.size(); ++b) {
      result.names.push_back(bodies_[b].name);
      if (bodies_[b].parts.empty()) result.untouched.push_back(static_cast<Id>(b) - first);
      (*zeros)[b].id = (*bodies)[b].id = static_cast<Id>(b) - first;
    }
    for (const auto& [name, body] : other_names_)
      if (static_cast<Id>(body) >= first) result.other_names.emplace_back(name, static_cast<Id>(body) - first);
    result.count = std::ssize(*bodies) - first;
    result.make = [bodies, first](Id k) { return (*bodies)[static_cast<std::size_t>(k + first)]; };
    add_joints(*zeros, result);
    add_loops(*zeros, result);
    add_couplings(result);
    add_notes(result);
    return result;
  }

 private:
  void read_wishes() {
    wishes_.resize(model_.joints.size());
    const Value* list = map_.find("joints");
    if (list == nullptr) return;
    for (const Value& entry : list->list("joints of the file")) {
      const KeyedMap of(entry, robot_joint_keys());
      const Value& name = of.need("name");
      const auto joint = std::ranges::find(model_.joints, name.text, &RobotJoint::name);
      if (joint == model_.joints.end() || !joint->has_coordinate()) {
        std::vector<std::string> names;
        for (const RobotJoint& other : model_.joints)
          if (other.has_coordinate()) names.push_back(other.name);
        name.fail(name.found() +
                      (joint == model_.joints.end()            ? ", a name that no joint of the file has"
                       : joint->kind == RobotJoint::Kind::ball ? ", a joint that turns every way"
                                                               : ", a joint that does not move") +
                      did_you_mean(name.text, names),
                  "the name of a joint of the file that moves");
      }
      Wish& wish = wishes_[static_cast<std::size_t>(joint - model_.joints.begin())];
      if (joint->mimic) name.fail(name.text + ", a joint that goes with " + joint->mimic->joint, "a joint that moves by itself");
      wish.at = of.number("at") * (joint->kind == RobotJoint::Kind::prismatic ? 1 : M_PI / 180);
      wish.motor = of.find("motor");
    }
  }

  std::size_t number_of(const std::string& joint) const {
    return static_cast<std::size_t>(std::ranges::find(model_.joints, joint, &RobotJoint::name) - model_.joints.begin());
  }

  // rad or m, of a joint at the start.
  double coordinate(std::size_t joint) const {
    const auto& mimic = model_.joints[joint].mimic;
    return mimic ? mimic->multiplier * wishes_[number_of(mimic->joint)].at + mimic->offset : wishes_[joint].at;
  }

  std::size_t add_body(std::size_t link, const Pose& zero, const Pose& start) {
    RobotBody& body = bodies_.emplace_back();
    body.name = model_.links[link].name, body.line = model_.links[link].line, body.zero = zero, body.start = start;
    return bodies_.size() - 1;
  }

  // Adds a link, and all that hangs on it, to bodies. zero, start: where it is; in_body: in the frame of its body.
  void place(std::size_t link, const Pose& zero, const Pose& start, std::size_t body, const Pose& in_body) {
    body_of_.resize(model_.links.size());
    body_of_[link] = body;
    bodies_[body].add_link(model_.links[link], in_body, files_);
    if (model_.links[link].name != bodies_[body].name) other_names_.emplace_back(model_.links[link].name, body);
    for (std::size_t j = 0; j < model_.joints.size(); ++j) {
      const RobotJoint& joint = model_.joints[j];
      if (joint.parent != link) continue;
      const double q = joint.has_coordinate() ? coordinate(j) : 0;
      Pose moved;
      if (joint.kind == RobotJoint::Kind::prismatic)
        moved.at = q * joint.axis;
      else
        moved.turn = Quat(Eigen::AngleAxisd(q, joint.axis)), moved.at = joint.anchor - moved.turn * joint.anchor;
      const Pose child_zero = zero * joint.pose, child_start = start * joint.pose * moved;
      if (joint.kind == RobotJoint::Kind::fixed) {
        place(joint.child, child_zero, child_start, body, in_body * joint.pose);
      } else {
        const std::size_t next = add_body(joint.child, child_zero, child_start);
        if (joint.kind != RobotJoint::Kind::floating) ties_.push_back({j, next, body});
        place(joint.child, child_zero, child_start, next, {});
      }
    }
  }

  // A root that is held needs no mass; what moves does.
  void add_root_mass(std::size_t b, bool is_held) {
    RobotBody& body = bodies_[b];
    if (body.mass > 0) return;
    if (b > 0 || !is_held)
      fail_at(files_.robot, body.line, "link " + quote(body.name) + " without <inertial>, nor one of what is fixed to it",
              "a mass and an inertia, since it moves");
    body.add_mass(1, Vec3::Zero(), Mat3::Identity());
  }

  // Adds a body as it is with all joints at 0, and as it starts.
  void make(std::size_t b, const BodyTemplate& common, std::vector<Body>& zeros, std::vector<Body>& starts) const {
    const Compound compound = solid_of(bodies_[b]);
    BodyTemplate own = common;
    own.properties.motion = Motion::dynamic, own.mass = bodies_[b].mass;
    if (!map_.flag("self_collision")) own.properties.group = group_without_contacts(scene_.body_count(), 0);
    const Vec3 centre = compound.centre;
    const Shape shape = shape_library().add(compound);
    zeros.push_back(make_body(own, shape, bodies_[b].zero * centre, bodies_[b].zero.turn));
    starts.push_back(make_body(own, shape, bodies_[b].start * centre, bodies_[b].start.turn));
  }

  // The second body of a joint; null: the world.
  const Body* body_at(const std::vector<Body>& zeros, std::size_t b) const { return b == 0 && !has_root_ ? nullptr : &zeros[b]; }

  void add_joints(const std::vector<Body>& zeros, Generated& result) {
    numbers_.assign(model_.joints.size(), -1);
    for (const Tie& tie : ties_) {
      const RobotJoint& from = model_.joints[tie.joint];
      const JointKind kind = from.kind == RobotJoint::Kind::prismatic ? JointKind::slider
                             : from.kind == RobotJoint::Kind::ball    ? JointKind::ball
                                                                      : JointKind::hinge;
      const Pose& zero = bodies_[tie.child].zero;
      Joint joint = joint_between(kind, zeros[tie.child], body_at(zeros, tie.parent), zero * from.anchor,
                                  joint_axes(zero.turn * from.axis));
      joint.viscosity = from.damping, joint.friction = from.friction;
      joint.stiffness = from.stiffness, joint.rest = from.rest;
      if (kind == JointKind::hinge && (from.lower < -M_PI || from.upper > M_PI) && from.upper < HUGE_VAL)
        result.notes.push_back(files_.robot + ": the limits of joint " + from.name + " reach over half a turn, and are left out");
      else
        joint.lower = from.lower, joint.upper = from.upper;
      joint.motor = from.motor, joint.target = from.target, joint.strength = from.strength;
      if (const Value* motor = wishes_[tie.joint].motor) read_motor(*motor, scene_, joint);
      numbers_[tie.joint] = std::ssize(result.joints);
      result.joints.push_back(joint), result.joint_names.push_back(from.name);
    }
  }

  void add_loops(const std::vector<Body>& zeros, Generated& result) const {
    for (const RobotLoop& loop : model_.loops) {
      std::array<std::size_t, 2> ends{body_of_[loop.links[0]], body_of_[loop.links[1]]};
      if (ends[0] == ends[1]) {
        result.notes.push_back(files_.robot + ": " + loop.name + " ties a body to itself, and is left out");
        continue;
      }
      const Vec3 point = frames_at_zero(loop.links[0]) * loop.anchor;
      if (body_at(zeros, ends[0]) == nullptr) std::swap(ends[0], ends[1]);
      result.joints.push_back(joint_between(loop.kind, zeros[ends[0]], body_at(zeros, ends[1]), point, Quat::Identity()));
      result.joint_names.push_back(loop.name);
    }
  }
  // Where a link is with all joints at 0.
  Pose frames_at_zero(std::size_t link) const {
    if (link == model_.root) return {};
    const RobotJoint& above = *std::ranges::find(model_.joints, link, &RobotJoint::child);
    return frames_at_zero(above.parent) * above.pose;
  }

  void add_couplings(Generated& result) const {
    for (const Tie& tie : ties_) {
      const auto& mimic = model_.joints[tie.joint].mimic;
      if (!mimic) continue;
      Coupling coupling;
      coupling.joints = {numbers_[tie.joint], numbers_[number_of(mimic->joint)]};
      coupling.ratio = mimic->multiplier;
      result.couplings.push_back(coupling);
    }
  }

  void add_notes(Generated& result) const {
    const std::string file = files_.robot + ": ";
    for (const RobotLink& link : model_.links)
      if (link.mass > 0 && !is_of_a_solid(link.inertia))
        result.notes.push_back(file + "link " + link.name +
                               " has moments of inertia that no solid has, one larger than the sum of the others; they are taken "
                               "as they are");
    for (const std::string& note : model_.notes) result.notes.push_back(file + note);
    if (!model_.unused.empty()) result.notes.push_back(file + "left out " + model_.unused);
  }

  const KeyedMap& map_;
  const Scene& scene_;
  const RobotModel& model_;
  const RobotFiles& files_;
  std::vector<Wish> wishes_;  // of each joint of the file
  std::vector<RobotBody> bodies_;
  std::vector<std::size_t> body_of_;  // each link
  std::vector<Tie> ties_;
  std::vector<std::int64_t> numbers_;                             // of the file's joints among the scene's; -1: it is none
  std::vector<std::pair<std::string, std::size_t>> other_names_;  // of links that are fixed to others, and their bodies
  bool has_root_ = true;
};

}  // namespace

const Keys& urdf_keys() {
  static const Keys table{
      "urdf",
      "A robot from a URDF file: a body for each link that moves, with the links that are fixed to it, and its joints.",
      {keys::text("file", "a URDF file", needed, "URDF file, its path from the scene's folder"),
       keys::choice("base", {"fixed", "free"}, "fixed", "whether the root link is held where it is"), links_touch_key(),
       keys::text("packages", "a folder", "the nearest folder above the file's that has the package",
                  "the folder of the packages that package:// names, its path from the scene's folder"),
       joints_key()}};
  return table;
}

const Keys& mjcf_keys() {
  static const Keys table{"mjcf",
                          "Robots and other bodies from an MJCF file, as MuJoCo reads it: a body for each of its bodies that "
                          "moves, and their joints.",
                          {keys::text("file", "an MJCF file", needed, "MJCF file, its path from the scene's folder"),
                           links_touch_key(), joints_key()}};
  return table;
}

Generated read_urdf_robot(const Value& value, const BodyTemplate& body, const Scene& scene) {
  const KeyedMap map(value, urdf_keys());
  RobotFiles files{path_of(map, scene), {}};
  if (const Value* folder = map.find("packages"))
    files.packages = std::filesystem::path(scene.path).parent_path() / folder->string(map.key("packages").words);
  const RobotModel model = read_urdf(files.robot);
  return Robot(map, scene, model, files).generate(body, map.choice("base") == 0);
}

Generated read_mjcf_robot(const Value& value, const BodyTemplate& body, const Scene& scene) {
  const KeyedMap map(value, mjcf_keys());
  const RobotFiles files{path_of(map, scene), {}};
  const RobotModel model = read_mjcf(files.robot);
  return Robot(map, scene, model, files).generate(body, true);
}

}  // namespace unibody
