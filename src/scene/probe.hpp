// A probe is a measurement that a scene asks for. Its results are further columns of report.csv.
#pragma once

#include <limits>
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

struct Probe {
  enum class Kind { flow, box, force, stress };

  std::string name;  // before its columns' names
  Kind kind = Kind::flow;
  ProbedBodies bodies;
  // Flow: through the disc about a point, counted along its normal. m, unit vector, m
  Vec3 point = Vec3::Zero(), normal = Vec3::UnitZ();
  double radius = std::numeric_limits<double>::infinity();
  Vec3 low = Vec3::Zero(), high = Vec3::Zero();  // m, box and stress: its corners
  // Force: on these bodies by contacts with those; the torque is about `point`.
  IdRange on, by{0, std::numeric_limits<Id>::max()};
};

}  // namespace unibody
