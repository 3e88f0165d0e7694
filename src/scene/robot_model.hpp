// A robot as a file of its own describes it: links with mass and shapes, and joints between them. What formats have in common;
// each has a reader (urdf_file.cpp, mjcf_file.cpp), and scene/robot.hpp makes bodies and joints of what they read.
#pragma once

#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "joints/joint.hpp"

namespace unibody {

// A place and a turn in the frame of a parent: x -> at + turn x.
struct Pose {
  Vec3 at = Vec3::Zero();  // m
  Quat turn = Quat::Identity();

  Pose operator*(const Pose& child) const { return {at + turn * child.at, (turn * child.turn).normalized()}; }
  Vec3 operator*(const Vec3& x) const { return at + turn * x; }
};

struct RobotShape {
  enum class Kind : std::uint8_t { box, cylinder, capsule, sphere, mesh, points };
  std::int64_t line = 0;
  Pose pose;  // in the link's frame
  Kind kind = Kind::box;
  // m: edges of a box; radius and length of a cylinder, or of a capsule without its caps; radius of a sphere; factors of a mesh
  Vec3 size = Vec3::Zero();
  std::string file;          // of a mesh, as it is written, or where it is from the robot's folder
  std::vector<Vec3> points;  // m, whose convex hull it is
  double density = 0;        // kg/m^3, with which it adds to the link's mass; or its
  double mass = 0;           // kg; 0 and 0: it adds nothing
  bool touches = true;
};

struct RobotLink {
  std::string name;
  std::int64_t line = 0;
  double mass = 0;              // kg, besides that of its shapes; 0: it says nothing of its mass
  Pose centre;                  // of mass, with the axes of the inertia, in the link's frame
  Mat3 inertia = Mat3::Zero();  // kg m^2, about the centre of mass, in those axes
  std::vector<RobotShape> shapes;
  // A link between two joints of one body has no mass of its own, and takes a small share of this link's. -1: it is none.
  std::int64_t between_joints_of = -1;
};

struct RobotMimic {
  std::string joint;
  double multiplier = 1, offset = 0;  // rad or m
};

struct RobotJoint {
  enum class Kind : std::uint8_t { fixed, revolute, prismatic, ball, floating };
  std::string name;
  std::int64_t line = 0;
  Kind kind = Kind::fixed;
  std::size_t parent = 0, child = 0;  // numbers of links
  Pose pose;                          // of the child's frame in the parent's, at the joint's zero
  Vec3 anchor = Vec3::Zero();         // m, in the child's frame
  Vec3 axis = Vec3::UnitX();          // unit, in the child's frame
  double lower = -std::numeric_limits<double>::infinity(), upper = -lower;  // rad or m, of a revolute or prismatic joint
  double stiffness = 0, rest = 0;                                           // N m/rad or N/m; rad or m
  double damping = 0, friction = 0;                                         // N m s/rad or N s/m; N m or N
  Motor motor = Motor::none;
  double target = 0, strength = 0;  // rad, m, rad/s or m/s; N m or N
  std::optional<RobotMimic> mimic;

  bool has_coordinate() const { return kind == Kind::revolute || kind == Kind::prismatic; }
};

// A ball or fixed joint that closes a loop, where the links are with all joints at 0.
struct RobotLoop {
  std::string name;
  JointKind kind = JointKind::ball;
  std::array<std::size_t, 2> links{};
  Vec3 anchor = Vec3::Zero();  // m, in the first link's frame
};

struct RobotModel {
  std::vector<RobotLink> links;
  std::vector<RobotJoint> joints;  // each child has one; they form a tree
  std::vector<RobotLoop> loops;
  std::size_t root = 0;        // the link that is nobody's child
  bool root_is_world = false;  // which does not move, and has no body where it has no shapes
  // What of the file is left out, as "transmission (2), gazebo (1)"; empty: nothing is. And what else a person should know.
  std::string unused;
  std::vector<std::string> notes;
};

// Throw InputError "file:line: found v, expected e" on the first fault.
RobotModel read_urdf(const std::string& path);
RobotModel read_mjcf(const std::string& path);

}  // namespace unibody
