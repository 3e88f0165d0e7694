// What collision detection hands to the solver: manifolds, in ascending key order, each a pure function of its pair.
#pragma once

#include "core/types.hpp"

namespace unibody {

// One point of a manifold.
struct ContactPoint {
  Vec3 position;          // m, world, half way across the gap; both bodies' arms reach to it, so that momentum is exact
  double gap;             // m, along the manifold's normal; positive when open
  std::uint32_t feature;  // names the vertex/edge/face pair it came from; ascending and unique within a manifold
};

// All contact points of one pair of bodies. They share one normal.
struct Manifold {
  Id id_a, id_b;  // the key: id_a < id_b
  Slot slot_a, slot_b;
  Vec3 normal;          // world, unit, from b towards a: a positive normal force pushes a along it
  double friction;      // Coulomb's mu of the pair
  std::uint32_t first;  // into Contacts::points
  std::uint32_t count;  // 1..8
};

struct Contacts {
  std::vector<Manifold> manifolds;  // ascending (id_a, id_b)
  std::vector<ContactPoint> points;

  void clear() { manifolds.clear(), points.clear(); }
};

}  // namespace unibody
