// Small worlds for the tests of collision detection, and a source of random numbers that is the same everywhere.
#pragma once

#include <algorithm>
#include <random>

#include "collide/collide.hpp"
#include "collide/cores.hpp"
#include "shortest_turn.hpp"

namespace unibody::samples {

struct Random {
  std::mt19937_64 engine;
  explicit Random(std::uint64_t seed) : engine(seed) {}
  double operator()(double low, double high) { return low + (high - low) * static_cast<double>(engine() >> 11) * 0x1p-53; }
  Vec3 vector(double low, double high) { return {(*this)(low, high), (*this)(low, high), (*this)(low, high)}; }
  Quat turn() { return Quat((*this)(-1, 1), (*this)(-1, 1), (*this)(-1, 1), (*this)(-1, 1) + 1e-3).normalized(); }
};

inline Body body(Id id, ShapeKind kind, const Vec3& size, const Vec3& position, Motion motion = Motion::dynamic) {
  Body b;
  b.id = id;
  b.properties.shape = {kind, size};
  b.properties.motion = motion;
  b.state.position = position;
  return b;
}
inline Body sphere(Id id, double radius, const Vec3& position) {
  return body(id, ShapeKind::sphere, Vec3(radius, 0, 0), position);
}
inline Body disc(Id id, double radius, const Vec3& position) { return body(id, ShapeKind::disc, Vec3(radius, 0, 0), position); }
inline Body box(Id id, const Vec3& half, const Vec3& position, const Quat& turn = Quat::Identity()) {
  Body b = body(id, ShapeKind::box, half, position);
  b.state.orientation = turn;
  return b;
}
inline Body plane(Id id, const Vec3& position = Vec3::Zero(), const Vec3& up = Vec3::UnitZ()) {
  Body b = body(id, ShapeKind::plane, Vec3::Zero(), position, Motion::fixed);
  b.state.orientation = shortest_turn(Vec3::UnitZ(), up);
  return b;
}

// Homes, then guests (the dynamic bodies of which `is_guest` says so), then statics, each in ascending id.
template <class IsGuest>
World world_of(std::vector<Body> bodies, IsGuest is_guest) {
  const auto range = [&](const Body& b) { return !b.properties.is_dynamic() ? 2 : is_guest(b.id) ? 1 : 0; };
  std::sort(bodies.begin(), bodies.end(),
            [&](const Body& a, const Body& b) { return std::pair(range(a), a.id) < std::pair(range(b), b.id); });
  World w;
  w.resize(bodies.size());
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    w.set(i, bodies[i]);
    w.homes += range(bodies[i]) == 0, w.guests += range(bodies[i]) == 1;
  }
  return w;
}
inline World world_of(const std::vector<Body>& bodies) {
  return world_of(bodies, [](Id) { return false; });
}

inline Contacts contacts_of(const World& world, const CollideSettings& settings) {
  Contacts c;
  collide(world, settings, c);
  return c;
}

// The one manifold of two bodies; count 0 if there is none.
struct Pair {
  Vec3 normal = Vec3::Zero();
  std::vector<ContactPoint> points;
  double smallest_gap() const {
    double g = HUGE_VAL;
    for (const auto& p : points) g = std::min(g, p.gap);
    return g;
  }
};
// Of the bodies as a whole; their cores' contacts are left out.
inline Pair collide_two(const Body& a, const Body& b, const CollideSettings& settings) {
  const Contacts c = contacts_of(world_of({a, b}), settings);
  Pair p;
  if (!c.manifolds.empty()) p.normal = c.manifolds[0].normal, p.points = c.points;
  std::erase_if(p.points, [](const ContactPoint& q) { return q.feature == core_feature; });
  return p;
}

inline bool same_bits(const Contacts& a, const Contacts& b) {
  if (a.manifolds.size() != b.manifolds.size() || a.points.size() != b.points.size()) return false;
  for (std::size_t i = 0; i < a.manifolds.size(); ++i) {
    const Manifold &p = a.manifolds[i], &q = b.manifolds[i];
    if (p.id_a != q.id_a || p.id_b != q.id_b || p.normal != q.normal || p.first != q.first || p.count != q.count) return false;
  }
  for (std::size_t i = 0; i < a.points.size(); ++i) {
    const ContactPoint &p = a.points[i], &q = b.points[i];
    if (p.position != q.position || p.gap != q.gap || p.feature != q.feature) return false;
  }
  return true;
}

}  // namespace unibody::samples
