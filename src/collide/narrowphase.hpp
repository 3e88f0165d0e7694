// Narrow phase: two bodies in, one manifold out. A table of functions by shape pair; a new shape is one file of such functions
// and one row of the table (narrowphase.cpp).
//
// Every function is pure: the same two bodies give the same bits, whatever their slots, the rank or the history.
#pragma once

#include "collide/collide_settings.hpp"
#include "collide/contacts.hpp"
#include "world/world.hpp"

namespace unibody {

// What collision needs to know of one body, gathered once a step.
struct Proxy {
  Vec3 position, velocity;
  Mat3 rotation;
  Vec3 half;          // m, half edges of a box; the radius in x otherwise
  double radius;      // m, bounding radius
  double speed;       // m/s
  double spin_reach;  // m, how far a rotation can carry a surface point in the step; 0 where it cannot change the shape
  double fall;        // m, |g| h^2 of a dynamic body: what its weight adds in the step
  double half_size;   // m, half of the smallest size
  ShapeKind kind;
  bool home, dynamic;
  std::int32_t material, group;
  Slot slot;
  Id id;
};

Proxy make_proxy(const World& world, std::size_t slot, const CollideSettings& settings);

// Points of one pair under construction; positions relative to the first body's centre.
struct PairManifold {
  static constexpr int capacity = 32, kept = 8;
  Vec3 normal = Vec3::UnitZ();  // from the second body towards the first
  int count = 0;
  ContactPoint points[capacity];

  void add(const Vec3& position, double gap, std::uint32_t feature) {
    if (count < capacity) points[count++] = {position, gap, feature};
  }
};

struct PairSettings {
  double margin;  // m, points with a larger gap are dropped
  bool planar;    // normals lie in the x-z plane, points have y = 0
};

// Distance (m) along the normal from which points are made contacts: eps + h max(|v_a.n|, |v_b.n|, |(v_a - v_b).n|) + both spins
// + |g.n| h^2. Not the relative speed alone: of two bodies falling together the lower may be stopped within the step.
double margin_along(const Vec3& normal, const Proxy& a, const Proxy& b, const CollideSettings& settings);

// A bound on it for any normal, before there is one.
double pair_margin(const Proxy& a, const Proxy& b, const CollideSettings& settings);

// The manifold of bodies a and b, a.id < b.id; count 0 when there is none. Points in ascending feature, in world coordinates.
void collide_pair(const Proxy& a, const Proxy& b, const CollideSettings& settings, PairManifold& manifold);

}  // namespace unibody
