// Robots described by URDF, the Unified Robot Description Format of ROS: links with mass and shapes, and joints between them.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/types.hpp"

namespace unibody {

// A place and a turn in the frame of a parent: x -> at + turn x.
struct Pose {
  Vec3 at = Vec3::Zero();  // m
  Quat turn = Quat::Identity();

  Pose operator*(const Pose& child) const { return {at + turn * child.at, (turn * child.turn).normalized()}; }
};

struct UrdfCollision {
  enum class Kind : std::uint8_t { box, cylinder, sphere, mesh };
  std::int64_t line = 0;
  Pose pose;  // in the link's frame
  Kind kind = Kind::box;
  Vec3 size = Vec3::Zero();  // m: edges of a box; radius and length of a cylinder; radius of a sphere; of a mesh the factors
  std::string file;          // of a mesh, as it is written
};

struct UrdfLink {
  std::string name;
  std::int64_t line = 0;
  double mass = 0;              // kg; 0: it says nothing of its mass
  Pose centre;                  // of mass, with the axes of the inertia, in the link's frame
  Mat3 inertia = Mat3::Zero();  // kg m^2, about the centre of mass, in those axes
  std::vector<UrdfCollision> collisions;
};

struct UrdfMimic {
  std::string joint;
  double multiplier = 1, offset = 0;  // rad or m
};

struct UrdfJoint {
  enum class Kind : std::uint8_t { fixed, revolute, continuous, prismatic, floating };
  std::string name;
  std::int64_t line = 0;
  Kind kind = Kind::fixed;
  std::size_t parent = 0, child = 0;  // numbers of links
  Pose pose;                          // of the child's frame in the parent's, at the joint's zero
  Vec3 axis = Vec3::UnitX();          // unit, in the child's frame
  double lower = 0, upper = 0;        // rad or m, of a revolute or prismatic joint
  double damping = 0, friction = 0;   // N m s/rad or N s/m; N m or N
  std::optional<UrdfMimic> mimic;

  bool moves() const { return kind == Kind::revolute || kind == Kind::continuous || kind == Kind::prismatic; }
};

struct Urdf {
  std::string name;
  std::vector<UrdfLink> links;
  std::vector<UrdfJoint> joints;  // each child has one; they form a tree
  std::size_t root = 0;           // the link that is nobody's child
  std::string unused;             // what of the file is left out, as "transmission (2), gazebo (1)"; empty: nothing is
};

// Throws InputError "file:line: found v, expected e" on the first fault.
Urdf read_urdf(const std::string& path);

}  // namespace unibody
