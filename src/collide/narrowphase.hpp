// Narrow phase: two bodies in, one manifold out. A table of functions by shape pair (narrowphase.cpp); shapes that it does not
// name meet as convex solids (convex_pairs.cpp), by what they say of themselves (world/shape_type.hpp).
//
// Every function is pure: the same two bodies give the same bits, whatever their slots, the rank or the history.
#pragma once

#include <functional>

#include "collide/collide_settings.hpp"
#include "collide/contacts.hpp"
#include "world/mesh_shape.hpp"
#include "world/world.hpp"

namespace unibody {

// What collision needs to know of one body, gathered once a step.
struct Proxy {
  Vec3 position, velocity;  // m, m/s
  Vec3 turn;                // rad/s, of a body whose motion is given; 0 of others
  Vec3 spin;                // rad/s, 0 of bodies whose turning does not show, and with that of the surface
  Mat3 rotation;
  Vec3 half;          // m, the shape's size; of round bodies the radius, three times
  double radius;      // m, bounding radius
  double speed;       // m/s, at the start of the step, or what it may be given in it
  double spin_reach;  // m, how far a rotation can carry a surface point in the step; 0 where it cannot change the shape
  double fall;        // m, |g| h^2 of a dynamic body: what its weight adds in the step
  double half_size;   // m, half of the smallest size
  double struck = 0;  // m/s, what others may give it in the step; 0: nothing that is known of
  ShapeKind kind;
  bool home, dynamic;
  std::int32_t material, group;
  Slot slot;
  Id id;
  double bounce_reach = 0;      // m, and how much further one that a bounce gives it
  Vec3 of_part = Vec3::Zero();  // m, from the whole body's centre
  Image image{};                // of a periodic scene's cell, where the body is; its position here is in the cell itself
  std::uint32_t data;           // of the shape

  Shape shape() const { return {kind, half, data}; }
  double turn_reach() const { return spin_reach + bounce_reach; }
  Vec3 centre() const { return position - of_part; }  // m, of the whole body
};

Proxy make_proxy(const World& world, std::size_t slot, const CollideSettings& settings);

// m/s: how fast two bodies move against each other, by which it is decided whether they are followed along the step: in the frame
// in which that is least, the world's or that of one whose motion is given and that turns. What goes round with a drum does not
// move against its wall.
double relative_speed(const Proxy& a, const Proxy& b);

// Points of one pair under construction; positions relative to the first body's centre at that time.
struct PairManifold {
  static constexpr int capacity = 64, kept = 8;
  Vec3 normal = Vec3::UnitZ();  // from the second body towards the first
  int count = 0;
  double time = 0;  // s, as Manifold's
  bool is_inner_ring = false;
  // The two convex parts that touch, or of a mesh the whole mesh and the triangle. They are valid while the manifold is handed
  // out, and null where the routine does not tell them.
  const Proxy *part_a = nullptr, *part_b = nullptr;
  const MeshSurface::Triangle* triangle = nullptr;
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

// Distances that differ by less than this share of them are alike. Which points of a regular face stay must not be a matter of
// rounding: they would change with every step, and what they bore in the last one be lost.
inline constexpr double alike_distances = 1e-6;

// Drops points beyond the margin, keeps at most PairManifold::kept of them, and puts them in the order of their features.
void tidy(PairManifold& manifold, double margin);

// m/s: the velocity of a against b with which the step will move them if nothing else acts; dynamic bodies fall.
Vec3 approach_velocity(const Proxy& a, const Proxy& b, const CollideSettings& settings);

// A bound on it for any normal, before there is one.
double pair_margin(const Proxy& a, const Proxy& b, const CollideSettings& settings);

// Calls f for each manifold of the two that has points, in the order of their parts: of simple shapes one, and those of their
// cores (cores.hpp) where they are fast; of compounds and meshes the same of each two parts or triangles near each other.
template <class F>
void collide_parts(const Proxy& a, const Proxy& b, const CollideSettings& settings, F&& f);
void collide_composites(const Proxy& a, const Proxy& b, const CollideSettings& settings,
                        const std::function<void(const PairManifold&)>& f);

// A compound's parts in place, or the shape itself.
void for_each_part(const Proxy& whole, const std::function<void(const Proxy&)>& f);

// The manifold of two simple shapes, a.id < b.id; count 0 when there is none. Points in ascending feature, in world coordinates.
void collide_pair(const Proxy& a, const Proxy& b, const CollideSettings& settings, PairManifold& manifold);

// The manifold of a's core (cores.hpp) and b, whose normal is from b to a; count 0 where there is none.
void collide_core(const Proxy& a, const Proxy& b, const CollideSettings& settings, PairManifold& manifold);

template <class F>
void collide_simple(const Proxy& a, const Proxy& b, const CollideSettings& settings, F&& f) {
  PairManifold found;
  found.part_a = &a, found.part_b = &b;
  collide_pair(a, b, settings, found);
  if (found.count > 0) f(found);
  if (collide_core(a, b, settings, found); found.count > 0) f(found);
  if (collide_core(b, a, settings, found); found.count > 0) found.normal = -found.normal, f(found);
}

template <class F>
void collide_parts(const Proxy& a, const Proxy& b, const CollideSettings& settings, F&& f) {
  if (is_composite(a.kind) || is_composite(b.kind)) return collide_composites(a, b, settings, f);
  collide_simple(a, b, settings, f);
}

}  // namespace unibody
