// Surfaces that move along themselves while their bodies do not, as that of a belt: what touches one meets a velocity which the
// body itself does not have.
#pragma once

#include <algorithm>
#include <vector>

#include "core/types.hpp"

namespace unibody {

// Of the bodies of one entry, over the step that is taken next.
struct SurfaceMotion {
  Id first = 0, count = 0;
  Vec3 velocity = Vec3::Zero(), angular_velocity = Vec3::Zero();  // m/s; rad/s about the centre; in the body's axes
};

// The same of one body in world axes: v + w x (p - centre).
struct OwnMotion {
  Vec3 v = Vec3::Zero(), w = Vec3::Zero();
};

// In order of their ids. Empty in most scenes.
using SurfaceMotions = std::vector<SurfaceMotion>;

inline const SurfaceMotion* find_motion(const SurfaceMotions& motions, Id id) {
  const auto after = std::ranges::upper_bound(motions, id, {}, &SurfaceMotion::first);
  if (after == motions.begin()) return nullptr;
  const SurfaceMotion& motion = *(after - 1);
  return id < motion.first + motion.count ? &motion : nullptr;
}

}  // namespace unibody
