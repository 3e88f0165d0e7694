// An outlet: a box in which bodies of a scene leave it.
#pragma once

#include <string>

#include "scene/probe.hpp"

namespace unibody {

// A dynamic body whose centre lies in the box at the start of a frame is absent from then on. Bodies with joints, and those to
// which a node is tied, stay.
struct Outlet {
  std::string name;
  ProbedBodies bodies;
  Vec3 low = Vec3::Zero(), high = Vec3::Zero();  // m, corners of the box
};

}  // namespace unibody
