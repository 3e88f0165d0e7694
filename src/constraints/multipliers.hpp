// The contact multipliers that persist from step to step: the only history of the simulation, part of every checkpoint.
// Keyed by (id, id); within a pair a new point takes the multipliers of the nearest old one in body a's frame.
#pragma once

#include <vector>

#include "core/types.hpp"

namespace unibody {

struct RememberedPoint {
  Vec3 place;       // m, contact point in the frame of body a (of b where a is static)
  double normal;    // N, along the normal
  Vec3 tangential;  // N, world frame, on body a
  std::uint32_t feature;
  std::uint32_t unused = 0;  // keeps every byte defined: these records are hashed and written as they are
};

struct RememberedManifold {
  Id id_a, id_b;               // id_a < id_b
  std::uint32_t first, count;  // into Multipliers::points
};

struct Multipliers {
  std::vector<RememberedManifold> manifolds;  // ascending (id_a, id_b); of all pairs with a home body here
  std::vector<RememberedPoint> points;
};

}  // namespace unibody
