// The generator `urdf`: the bodies and joints of a robot's file.
#include "scene/urdf.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <stdexcept>

#include "core/errors.hpp"
#include "core/text.hpp"
#include "meshes/mesh_file.hpp"
#include "meshes/surface_file.hpp"
#include "scene/articulated.hpp"
#include "scene/joint_keys.hpp"
#include "scene/joints.hpp"
#include "scene/urdf_file.hpp"
#include "world/shape_library.hpp"

namespace unibody {

namespace {

constexpr double degree = M_PI / 180;

const Keys& turning_motor_of_urdf() { return motor_keys(true); }
const Keys& sliding_motor_of_urdf() { return motor_keys(false); }

const Keys& urdf_joint_keys() {
  static const Keys table{
      "urdf_joint",
      "A joint of a robot: where it is at the start, and its motor.",
      {keys::text("name", "the name of a joint of the file", needed, "the joint"),
       keys::number("at", "degrees or m", any_number, 0, "angle or offset at the start"),
       keys::other("motor", "", "a map", "none", "its motor, as of a hinge or slider",
                   [] {
                     return keys::any_of({keys::reference_to(turning_motor_of_urdf), keys::reference_to(sliding_motor_of_urdf)});
                   },
                   {turning_motor_of_urdf, sliding_motor_of_urdf})}};
  return table;
}

// A joint's own entry in the scene.
struct Wish {
  double at = 0;  // rad or m
  const Value* motor = nullptr;
};

// A body: a link of the robot, and those that fixed joints tie to it.
struct RobotBody {
  std::string name;           // of its first link, in whose frame the rest is
  std::int64_t line = 0;      // of that link
  Pose zero, start;           // of that frame, with all joints at 0, and at the start
  double mass = 0;            // kg
  Vec3 first = Vec3::Zero();  // kg m, mass times centre
  Mat3 about = Mat3::Zero();  // kg m^2, inertia about the frame's origin
  std::vector<Compound::Part> parts;

  void add_mass(double m, const Vec3& centre, const Mat3& inertia) {
    mass += m, first += m * centre;
    about += inertia + m * (centre.squaredNorm() * Mat3::Identity() - centre * centre.transpose());
  }
};

// Whether a solid can have this inertia: none of its principal moments is larger than the sum of the other two.
bool is_of_a_solid(const Mat3& inertia) {
  const Vec3 moments = Eigen::SelfAdjointEigenSolver<Mat3>(inertia, Eigen::EigenvaluesOnly).eigenvalues();
  return 2 * moments.maxCoeff() <= moments.sum() * (1 + 1e-9);
}

class Robot {
 public:
  Robot(const KeyedMap& map, const Scene& scene)
      : map_(map), scene_(scene), path_(surface_path_of(map, scene)), urdf_(read_urdf(path_)) {
    packages_ = std::filesystem::path(path_).parent_path();
    if (const Value* folder = map.find("packages"))
      packages_ = std::filesystem::path(scene.path).parent_path() / folder->string(map.key("packages").words);
    read_wishes();
    place(urdf_.root, {}, {}, add_body(urdf_.root, {}, {}), {});
  }

  Generated generate(const BodyTemplate& common) {
    const bool is_held = map_.choice("base") == 0;
    auto bodies = std::make_shared<std::vector<Body>>(), zeros = std::make_shared<std::vector<Body>>();
    Generated result;
    for (std::size_t b = 0; b < bodies_.size(); ++b) {
      RobotBody& body = bodies_[b];
      result.names.push_back(body.name);
      if (body.parts.empty()) result.untouched.push_back(static_cast<Id>(b));
      const Compound compound = solid_of(body, b == 0 && is_held);
      const Vec3 centre = compound.centre;
      BodyTemplate own = common;
      own.properties.motion = Motion::dynamic, own.mass = body.mass;
      if (!map_.flag("self_collision")) own.properties.group = group_without_contacts(scene_.body_count(), 0);
      const Shape shape = shape_library().add(compound);
      const auto make = [&](const Pose& pose) { return make_body(own, shape, pose.at + pose.turn * centre, pose.turn); };
      zeros->push_back(make(body.zero)), bodies->push_back(make(body.start));
      zeros->back().id = bodies->back().id = static_cast<Id>(b);
      if (b == 0 && is_held) bodies->back().properties.motion = Motion::pinned;
    }
    result.other_names = other_names_;
    result.count = static_cast<Id>(bodies->size());
    result.make = [bodies](Id k) { return (*bodies)[static_cast<std::size_t>(k)]; };
    add_joints(*zeros, result);
    for (const UrdfLink& link : urdf_.links)
      if (link.mass > 0 && !is_of_a_solid(link.inertia))
        result.notes.push_back(path_ + ": link " + link.name +
                               " has moments of inertia that no solid has, one larger than the sum of the others; they are taken "
                               "as they are");
    if (!urdf_.unused.empty()) result.notes.push_back(path_ + ": left out " + urdf_.unused);
    return result;
  }

 private:
  static std::string surface_path_of(const KeyedMap& map, const Scene& scene) {
    const Value& file = map.need("file");
    const auto path = std::filesystem::path(scene.path).parent_path() / file.string(map.key("file").words);
    if (scene.planar) file.fail_expected("no robot in a planar scene");
    return path.string();
  }

  void read_wishes() {
    wishes_.resize(urdf_.joints.size());
    const Value* list = map_.find("joints");
    if (list == nullptr) return;
    for (const Value& entry : list->list("joints of the file")) {
      const KeyedMap of(entry, urdf_joint_keys());
      const Value& name = of.need("name");
      const auto joint = std::ranges::find(urdf_.joints, name.text, &UrdfJoint::name);
      if (joint == urdf_.joints.end() || !joint->moves()) {
        std::vector<std::string> names;
        for (const UrdfJoint& other : urdf_.joints)
          if (other.moves()) names.push_back(other.name);
        name.fail(name.found() +
                      (joint == urdf_.joints.end() ? ", a name that no joint of the file has" : ", a joint that does not move") +
                      did_you_mean(name.text, names),
                  "the name of a joint of the file that moves");
      }
      Wish& wish = wishes_[static_cast<std::size_t>(joint - urdf_.joints.begin())];
      if (joint->mimic) name.fail(name.text + ", a joint that goes with " + joint->mimic->joint, "a joint that moves by itself");
      wish.at = of.number("at") * (joint->kind == UrdfJoint::Kind::prismatic ? 1 : degree);
      wish.motor = of.find("motor");
    }
  }

  // rad or m, of a joint at the start.
  double coordinate(std::size_t joint) const {
    const auto& mimic = urdf_.joints[joint].mimic;
    if (!mimic) return wishes_[joint].at;
    const auto other = std::ranges::find(urdf_.joints, mimic->joint, &UrdfJoint::name);
    return mimic->multiplier * wishes_[static_cast<std::size_t>(other - urdf_.joints.begin())].at + mimic->offset;
  }

  std::size_t add_body(std::size_t link, const Pose& zero, const Pose& start) {
    RobotBody& body = bodies_.emplace_back();
    body.name = urdf_.links[link].name, body.line = urdf_.links[link].line, body.zero = zero, body.start = start;
    return bodies_.size() - 1;
  }

  // Adds a link, and all that hangs on it, to bodies. zero, start: where it is; in_body: in the frame of its body.
  void place(std::size_t link, const Pose& zero, const Pose& start, std::size_t body, const Pose& in_body) {
    add_link(urdf_.links[link], bodies_[body], in_body);
    if (urdf_.links[link].name != bodies_[body].name) other_names_.emplace_back(urdf_.links[link].name, static_cast<Id>(body));
    for (std::size_t j = 0; j < urdf_.joints.size(); ++j) {
      const UrdfJoint& joint = urdf_.joints[j];
      if (joint.parent != link) continue;
      const double q = joint.moves() ? coordinate(j) : 0;
      Pose moved;
      if (joint.kind == UrdfJoint::Kind::prismatic)
        moved.at = q * joint.axis;
      else
        moved.turn = Quat(Eigen::AngleAxisd(q, joint.axis));
      const Pose child_zero = zero * joint.pose, child_start = start * joint.pose * moved;
      if (joint.kind == UrdfJoint::Kind::fixed) {
        place(joint.child, child_zero, child_start, body, in_body * joint.pose);
      } else {
        const std::size_t next = add_body(joint.child, child_zero, child_start);
        if (joint.moves()) ties_.push_back({j, next, body});
        place(joint.child, child_zero, child_start, next, {});
      }
    }
  }

  void add_link(const UrdfLink& link, RobotBody& body, const Pose& in_body) {
    if (link.mass > 0) {
      const Pose centre = in_body * link.centre;
      const Mat3 turn = centre.turn.toRotationMatrix();
      body.add_mass(link.mass, centre.at, turn * link.inertia * turn.transpose());
    }
    for (const UrdfCollision& collision : link.collisions) {
      const Pose pose = in_body * collision.pose;
      const Vec3& size = collision.size;
      switch (collision.kind) {
        case UrdfCollision::Kind::box:
          body.parts.push_back({{ShapeKind::box, 0.5 * size}, pose.at, pose.turn});
          break;
        case UrdfCollision::Kind::sphere:
          body.parts.push_back({{ShapeKind::sphere, Vec3(size.x(), 0, 0)}, pose.at, pose.turn});
          break;
        case UrdfCollision::Kind::cylinder:
          body.parts.push_back({{ShapeKind::cylinder, Vec3(size.x(), size.x(), 0.5 * size.y())}, pose.at, pose.turn});
          break;
        case UrdfCollision::Kind::mesh:
          body.parts.push_back(hull_of(collision, pose));
          break;
      }
    }
  }

  Compound::Part hull_of(const UrdfCollision& collision, const Pose& pose) const {
    const std::string path = mesh_path(collision);
    TriangleMesh mesh = read_surface(path, true);
    for (Vec3& x : mesh.nodes) x = x.cwiseProduct(collision.size);
    try {
      Hull hull = make_hull(mesh.nodes);
      const Vec3 centre = hull.centre;
      return {shape_library().add(std::move(hull)), pose.at + pose.turn * centre, pose.turn};
    } catch (const std::invalid_argument& fault) {
      fail_at(path_, collision.line, "mesh " + quote(collision.file) + " of " + fault.what(), "a mesh that spans a solid");
    }
  }

  // package://NAME/REST is NAME/REST in the folder of packages, or in the nearest folder above the file's that has it.
  std::string mesh_path(const UrdfCollision& collision) const {
    namespace fs = std::filesystem;
    constexpr std::string_view package = "package://", file = "file://";
    std::string name = collision.file;
    fs::path path;
    std::error_code error;
    if (name.starts_with(package)) {
      name.erase(0, package.size());
      path = packages_ / name;
      if (!map_.has("packages"))
        for (fs::path up = fs::absolute(packages_, error); !fs::is_regular_file(path, error) && up != up.root_path();
             up = up.parent_path())
          path = up / name;
    } else {
      if (name.starts_with(file)) name.erase(0, file.size());
      path = fs::path(path_).parent_path() / name;
    }
    if (!fs::is_regular_file(path, error))
      fail_at(path_, collision.line, "mesh " + quote(collision.file) + ", which isn't at " + path.string(),
              map_.has("packages") || !collision.file.starts_with(package)
                  ? "a file that is there"
                  : "a file that is there (packages: the folder of packages)");
    std::string ending = path.extension().string();
    std::ranges::transform(ending, ending.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    if (ending != ".obj" && ending != ".stl")
      fail_at(path_, collision.line, "mesh " + quote(collision.file), "an OBJ or STL file");
    return path.string();
  }

  // A body that touches nothing is a ball of its inertia. One that is held needs no mass.
  Compound solid_of(RobotBody& body, bool is_held) const {
    if (body.mass == 0) {
      if (!is_held)
        fail_at(path_, body.line, "link " + quote(body.name) + " without <inertial>, nor one of what is fixed to it",
                "a mass and an inertia, since it moves");
      body.add_mass(1, Vec3::Zero(), Mat3::Identity());
    }
    const Vec3 centre = body.first / body.mass;
    const Mat3 inertia = body.about - body.mass * (centre.squaredNorm() * Mat3::Identity() - centre * centre.transpose());
    const Mat3 second = 0.5 * inertia.trace() * Mat3::Identity() - inertia;
    std::vector<Compound::Part> parts = body.parts;
    if (parts.empty()) {
      const double radius = std::sqrt(2.5 * inertia.trace() / (3 * body.mass));
      parts.push_back({{ShapeKind::sphere, Vec3(radius, 0, 0)}, centre, Quat::Identity()});
    }
    double volume_of_all = 0;
    for (const Compound::Part& part : parts) volume_of_all += volume(part.shape);
    return make_compound(parts, moments_of(volume_of_all, centre, second / body.mass));
  }

  void add_joints(const std::vector<Body>& zeros, Generated& result) const {
    std::vector<std::int64_t> numbers(urdf_.joints.size(), -1);
    for (const Tie& tie : ties_) {
      const UrdfJoint& from = urdf_.joints[tie.joint];
      const JointKind kind = from.kind == UrdfJoint::Kind::prismatic ? JointKind::slider : JointKind::hinge;
      const Pose& zero = bodies_[tie.child].zero;
      Joint joint = joint_between(kind, zeros[tie.child], &zeros[tie.parent], zero.at, joint_axes(zero.turn * from.axis));
      joint.viscosity = from.damping, joint.friction = from.friction;
      const bool is_limited = from.kind != UrdfJoint::Kind::continuous;
      if (is_limited && kind == JointKind::hinge && (from.lower < -M_PI || from.upper > M_PI))
        result.notes.push_back(path_ + ": the limits of joint " + from.name + " reach over half a turn, and are left out");
      else if (is_limited)
        joint.lower = from.lower, joint.upper = from.upper;
      if (const Value* motor = wishes_[tie.joint].motor) read_motor(*motor, scene_, joint);
      numbers[tie.joint] = std::ssize(result.joints);
      result.joints.push_back(joint), result.joint_names.push_back(from.name);
    }
    for (const Tie& tie : ties_) {
      const auto& mimic = urdf_.joints[tie.joint].mimic;
      if (!mimic) continue;
      const auto other = std::ranges::find(urdf_.joints, mimic->joint, &UrdfJoint::name);
      Coupling coupling;
      coupling.joints = {numbers[tie.joint], numbers[static_cast<std::size_t>(other - urdf_.joints.begin())]};
      coupling.ratio = mimic->multiplier;
      result.couplings.push_back(coupling);
    }
  }

  struct Tie {
    std::size_t joint, child, parent;  // number of the file's joint, and of its bodies
  };
  const KeyedMap& map_;
  const Scene& scene_;
  const std::string path_;
  const Urdf urdf_;
  std::filesystem::path packages_;
  std::vector<Wish> wishes_;  // of each joint of the file
  std::vector<RobotBody> bodies_;
  std::vector<Tie> ties_;
  std::vector<std::pair<std::string, Id>> other_names_;  // of links that are fixed to others
};

}  // namespace

const Keys& urdf_keys() {
  static const Keys table{
      "urdf",
      "A robot from a URDF file: a body for each link that moves, with the links that are fixed to it, and its joints.",
      {keys::text("file", "a URDF file", needed, "URDF file, its path from the scene's folder"),
       keys::choice("base", {"fixed", "free"}, "fixed", "whether the root link is held where it is"),
       keys::flag("self_collision", false, "its links may touch each other, but for those that a joint ties"),
       keys::text("packages", "a folder", "the nearest folder above the file's that has the package",
                  "the folder of the packages that package:// names, its path from the scene's folder"),
       keys::list_of_maps("joints", urdf_joint_keys, "a list of joints of the file", "none",
                          "where joints are at the start, and their motors")}};
  return table;
}

Generated read_urdf_robot(const Value& value, const BodyTemplate& body, const Scene& scene) {
  const KeyedMap map(value, urdf_keys());
  return Robot(map, scene).generate(body);
}

}  // namespace unibody
