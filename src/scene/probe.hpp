// A probe is a measurement that a scene asks for. Its results are further columns of report.csv.
#pragma once

#include <array>
#include <limits>
#include <memory>
#include <string>

#include "core/types.hpp"

namespace unibody {

// Which bodies a probe is about: dynamic ones, of a run of ids and perhaps of one material.
struct ProbedBodies {
  Id first = 0, end = 0;
  int material = -1;  // -1: any
};

// A run of ids.
struct IdRange {
  Id first = 0, end = 0;
  bool holds(Id id) const { return id >= first && id < end; }
};

// The room between six plates, the bodies 0 to 5 of an entry: below and above along x, y and z. In a planar scene it has four,
// along x and z.
struct TriaxialCell {
  Vec3 size = Vec3::Zero();    // m, at the start
  Vec3 corner = Vec3::Zero();  // m, of the room: where the lower plates meet
  Quat axes = Quat::Identity();
  std::array<int, 3> plates{-1, -1, -1};  // along each axis, the number of the lower plate; the upper one follows. -1: none
};

struct Probe {
  enum class Kind { flow, box, force, stress, cell };

  std::string name;  // before its columns' names
  Kind kind = Kind::flow;
  ProbedBodies bodies;
  // Flow: through the disc about a point, counted along its normal. m, unit vector, m
  Vec3 point = Vec3::Zero(), normal = Vec3::UnitZ();
  double radius = std::numeric_limits<double>::infinity();
  Vec3 low = Vec3::Zero(), high = Vec3::Zero();  // m, box and stress: its corners
  // Force: on these bodies by contacts with those; the torque is about `point`.
  IdRange on, by{0, std::numeric_limits<Id>::max()};
  std::shared_ptr<const TriaxialCell> cell;  // whose plates the bodies `on` are
};

}  // namespace unibody
