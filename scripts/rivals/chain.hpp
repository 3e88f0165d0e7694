// A chain as every program measured here ties it: each dynamic body to the one before by a ball joint, the first to the world.
#pragma once

#include <vector>

#include "bodies.hpp"

namespace rivals {

struct Anchor {
  long a = -1;  // body, -1: the world
  long b = 0;
  Vec3 in_a, in_b;  // m, the anchor in the axes of a (the world's: where it is) and b, from the centre
};

// The joints of a chain of equal links along their x axes, with a heavier body at its end or not: the dynamic bodies of `start`
// in order, as Unibody's generator makes them. The k-th anchor is where link k starts, the last where the last link ends. Throws
// std::runtime_error with fewer than two links.
std::vector<Anchor> chain_anchors(const Bodies& bodies, const Frame& start);

struct Drift {
  double rms = 0, max = 0;  // m, distance between the two places of an anchor
};
Drift chain_drift(const std::vector<Anchor>& anchors, const Frame& frame);

}  // namespace rivals
