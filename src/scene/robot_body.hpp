// The mass and the shape of a robot's body: of a link, and of those that fixed joints tie to it.
#pragma once

#include <filesystem>

#include "scene/robot_model.hpp"
#include "world/compound.hpp"

namespace unibody {

// Where a robot's file finds its meshes.
struct RobotFiles {
  std::string robot;               // the robot's file
  std::filesystem::path packages;  // package://NAME/REST is NAME/REST in this folder; empty: in the nearest above that has it
};

struct RobotBody {
  std::string name;           // of its first link, in whose frame the rest is
  std::int64_t line = 0;      // of that link
  Pose zero, start;           // of that frame, with all joints at 0, and at the start
  double mass = 0;            // kg
  Vec3 first = Vec3::Zero();  // kg m, mass times centre
  Mat3 about = Mat3::Zero();  // kg m^2, inertia about the frame's origin
  std::vector<Compound::Part> parts;

  void add_mass(double m, const Vec3& centre, const Mat3& inertia);
  // Throws InputError where a mesh is not there, or spans no solid.
  void add_link(const RobotLink& link, const Pose& in_body, const RobotFiles& files);
  // Takes a share of another body's mass, which is in the same frame.
  void take_share(double share, RobotBody& from);
};

// A body that touches nothing is a ball of its inertia.
Compound solid_of(const RobotBody& body);

// Whether a solid can have this inertia: none of its principal moments is larger than the sum of the other two.
bool is_of_a_solid(const Mat3& inertia);

}  // namespace unibody
