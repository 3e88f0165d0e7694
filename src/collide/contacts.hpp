// What collision detection hands to the solver: manifolds, in ascending key order, each a pure function of its pair.
#pragma once

#include <array>
#include <tuple>
#include <utility>
#include <vector>

#include "collide/friction_frame.hpp"
#include "world/world.hpp"

namespace unibody {

// One point of a manifold.
struct ContactPoint {
  Vec3 position;          // m, world, half way across the gap, when the manifold's bodies are at its time
  double gap;             // m, along the manifold's normal; positive when open
  std::uint32_t feature;  // names the vertex/edge/face pair it came from; ascending and unique within a manifold
};

// All contact points of one pair of bodies. They share one normal.
//
// Bodies that move further in the step than their size are in contact as they will first touch, at `time`, moved on at their
// velocities but not turned. Their arms are those of that moment: else an impact without friction would spin balls.
struct Manifold {
  Id id_a, id_b;  // the key: id_a < id_b
  Slot slot_a, slot_b;
  Vec3 normal;           // world, unit, from b towards a: a positive normal force pushes a along it
  double friction;       // Coulomb's mu of the pair
  std::uint32_t first;   // into Contacts::points
  std::uint32_t count;   // 1..8
  double time = 0;       // s, since the start of the step
  double displaced = 0;  // m, along the normal: part of the gaps, where impacts in the step let bodies seem to start it elsewhere
  bool is_inner_ring = false;  // of the manifold before it (face_patch.hpp)
  Image image{};               // which image of b touches a: points are placed where a is
};

// Where a body of the manifold is at the start of the step (m), as seen from the first: the second is an image of itself where
// the two touch across a border of a periodic scene.
inline Vec3 place_of(const World& world, const Manifold& m, Slot slot) {
  const Vec3& place = world.position[static_cast<std::size_t>(slot)];
  return slot == m.slot_b && m.image != Image{} ? Vec3(place + world.period.shift(m.image)) : place;
}

// The same at the manifold's time.
inline Vec3 place_then(const World& world, const Manifold& m, Slot slot) {
  const Vec3 place = place_of(world, m, slot);
  return m.time > 0 ? Vec3(place + m.time * world.velocity[static_cast<std::size_t>(slot)]) : place;
}

inline bool is_particle(const World& world, Slot slot) {
  return world.properties[static_cast<std::size_t>(slot)].shape.kind == ShapeKind::particle;
}

// The arm (m) from a body's centre to where the contact's forces act on it: the point, both where they are at the manifold's
// time. A particle has no turn of its own: forces on it act at its centre, on the other body too. So angular momentum is kept,
// and what lies on a turning body goes round with it, where the body's surface itself is faster or slower by the particle's
// radius. Where a body that is not round touches one that forces do not move, the arm ends on the body's own surface: from half
// way across the gap friction would turn the body too much, as it does spheres that land.
inline Vec3 arm_of(const World& world, const Manifold& m, const ContactPoint& point, Slot slot) {
  const Slot other = slot == m.slot_a ? m.slot_b : m.slot_a;
  Vec3 arm = (is_particle(world, other) ? place_then(world, m, other) : point.position) - place_then(world, m, slot);
  const auto& body = world.properties[static_cast<std::size_t>(slot)];
  if (m.time > 0 || is_particle(world, other) || world.properties[static_cast<std::size_t>(other)].is_dynamic()) return arm;
  if (is_round(body.shape)) return arm;
  const double half_gap = 0.5 * std::max(0.0, point.gap - m.displaced);
  arm += (slot == m.slot_a ? half_gap : -half_gap) * m.normal;
  return arm;
}

// A contact of a surface: of a body or a node with a face, or of two edges. Each side is one point, a body's own or the mean of
// nodes by weight; the velocity at which the sides part is the sum of weight times velocity over the ends, and an impulse is
// shared out by the same weights, so that momentum is kept (paper, section 5).
struct SurfaceContact {
  std::array<Id, 4> ids;  // of the ends; -1: none. With the feature the key, which is unique
  // Which part of the other body or mesh touches: of a box its corner, or 11 + 3 times its edge (triangle_contacts.hpp); of a
  // mesh twice its node, or 1 + twice its edge, where triangle t has the edges 3 t to 3 t + 2; 1000 where two edges of surfaces
  // touch; else 0.
  std::uint32_t feature;
  std::array<Slot, 4> slots;
  std::array<double, 4> weights;  // of the first side positive, sum 1; of the second negative, sum -1; 0: no such end
  Vec3 arm;                       // m, from the centre of end 0 to where it is touched; 0 where that is a node
  Vec3 normal;                    // world, unit, from the second side to the first
  double gap;                     // m, along it; positive when open
  double friction;                // Coulomb's mu of the pair
  double beyond;                  // m, how far the sides must part to be on the sides again where they were; 0: they are
  double bounce = 0;              // m/s, the speed at which they must part; 0: they need not

  bool before(const SurfaceContact& other) const { return std::tie(ids, feature) < std::tie(other.ids, other.feature); }
};

struct Contacts {
  std::vector<Manifold> manifolds;  // ascending (id_a, id_b); of bodies of many parts several in a row, in the parts' order
  std::vector<ContactPoint> points;
  std::vector<double> bounce;           // m/s, of each point: the speed at which the bodies must part; empty: nothing bounces
  std::vector<SurfaceContact> surface;  // ascending keys
  // Of each of `manifolds` and of `surface`. Empty: friction is the same in all directions, everywhere.
  std::vector<FrictionFrame> frames, surface_frames;

  void clear() { manifolds.clear(), points.clear(), bounce.clear(), surface.clear(), frames.clear(), surface_frames.clear(); }

  // Of one of `manifolds`, and of one of `surface`.
  FrictionFrame frame_of(const Manifold& m) const {
    return frames.empty() ? FrictionFrame{first_tangent_of(m.normal)} : frames[static_cast<std::size_t>(&m - manifolds.data())];
  }
  // Of one of `manifolds` whose normal has turned to n.
  FrictionFrame frame_at(const Manifold& m, const Vec3& n) const {
    if (frames.empty()) return {first_tangent_of(n)};
    const FrictionFrame frame = frame_of(m);
    return {frame.turned_to(n), frame.across};
  }
  FrictionFrame frame_of(const SurfaceContact& c) const {
    if (surface_frames.empty()) return {first_tangent_of(c.normal)};
    return surface_frames[static_cast<std::size_t>(&c - surface.data())];
  }
};

// Takes away the manifolds for which unwanted(manifold), with their points and what is said of these. Before they have frames.
template <class Unwanted>
void leave_out(Contacts& contacts, Unwanted&& unwanted) {
  std::vector<Manifold> manifolds;
  std::vector<ContactPoint> points;
  std::vector<double> bounce;
  for (Manifold m : contacts.manifolds) {
    if (unwanted(m)) continue;
    const auto from = contacts.points.begin() + m.first;
    if (!contacts.bounce.empty()) {
      const auto speed = contacts.bounce.begin() + m.first;
      bounce.insert(bounce.end(), speed, speed + m.count);
    }
    m.first = static_cast<std::uint32_t>(points.size());
    points.insert(points.end(), from, from + m.count);
    manifolds.push_back(m);
  }
  contacts.manifolds = std::move(manifolds), contacts.points = std::move(points), contacts.bounce = std::move(bounce);
}

}  // namespace unibody
