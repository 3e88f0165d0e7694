// A coupling of two joints, as by gears, a rack, a screw or a belt: the coordinate of the first, a hinge's angle or a slider's
// offset, is `ratio` times that of the second and a constant, which is what it is at the start. Angles count on through whole
// turns.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/types.hpp"
#include "joints/joint.hpp"

namespace unibody {

struct Coupling {
  std::array<std::int64_t, 2> joints{};  // their numbers in Scene::joints
  double ratio = 1;                      // of the unit of the first (rad or m) over that of the second
  std::array<Id, 4> ids{};               // the two bodies of each joint; the second of each may be -1: the world
  std::int32_t colour = 0;               // two couplings of a colour share no moving body
};

// The same with the bodies of its joints.
inline Coupling with_bodies(Coupling coupling, std::span<const Joint> joints) {
  for (std::size_t k = 0; k < 2; ++k) {
    const Joint& joint = joints[static_cast<std::size_t>(coupling.joints[k])];
    coupling.ids[2 * k] = joint.ids[0], coupling.ids[2 * k + 1] = joint.ids[1];
  }
  return coupling;
}

// The bodies of a coupling on this rank.
struct CouplingSlots {
  std::array<Slot, 4> slots{};  // of the world: the body that is nobody
  bool counted = true;          // this rank counts it in sums over all ranks
};

}  // namespace unibody
