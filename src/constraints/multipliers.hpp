// The contact multipliers that persist from step to step: the contacts' part of the history (step/history.hpp).
// Keyed by (id, id); within a pair a new point takes the multipliers of the nearest old one in body a's frame. Where one body is
// round there is but one point, and no place is kept.
#pragma once

#include <span>
#include <vector>

#include "core/types.hpp"

namespace unibody {

struct RememberedPoint {
  double normal;    // N, along the normal
  Vec3 tangential;  // N, world frame, on body a
};

// What two bodies that stick have slipped beside what they were asked for, body a against b: see creep.hpp. World frame.
struct Creep {
  Vec3 slip = Vec3::Zero();  // m, across the normal, where the smaller body's centre is
  Vec3 turn = Vec3::Zero();  // rad, about the normal

  bool is_zero() const { return slip.isZero(0) && turn.isZero(0); }
};

struct RememberedManifold {
  Id id_a, id_b;                           // id_a < id_b
  std::uint32_t first_point, first_place;  // into Multipliers::points and places; they end where the next manifold's begin
};

struct Multipliers {
  std::vector<RememberedManifold> manifolds;  // ascending (id_a, id_b); of all pairs with a home body here
  std::vector<RememberedPoint> points;
  std::vector<Creep> creeps;  // of each manifold or of none
  std::vector<Vec3> places;   // m, of each point of a manifold or of none, in the frame of body a (of b where a is static)

  std::span<const RememberedPoint> points_of(std::size_t m) const {
    const std::size_t first = manifolds[m].first_point;
    return {points.data() + first, (m + 1 < manifolds.size() ? manifolds[m + 1].first_point : points.size()) - first};
  }
  std::span<const Vec3> places_of(std::size_t m) const {
    const std::size_t first = manifolds[m].first_place;
    return {places.data() + first, (m + 1 < manifolds.size() ? manifolds[m + 1].first_place : places.size()) - first};
  }

  void begin_manifold(Id id_a, Id id_b) {
    manifolds.push_back({id_a, id_b, static_cast<std::uint32_t>(points.size()), static_cast<std::uint32_t>(places.size())});
  }
  Creep creep_of(std::size_t m) const { return creeps.empty() ? Creep{} : creeps[m]; }
  void set_last_creep(const Creep& creep) {
    creeps.resize(manifolds.size());
    creeps.back() = creep;
  }
  void append(const Multipliers& from, std::size_t m) {
    const auto new_points = from.points_of(m);
    const auto new_places = from.places_of(m);
    begin_manifold(from.manifolds[m].id_a, from.manifolds[m].id_b);
    if (!from.creeps.empty() || !creeps.empty()) set_last_creep(from.creep_of(m));
    points.insert(points.end(), new_points.begin(), new_points.end());
    places.insert(places.end(), new_places.begin(), new_places.end());
  }
};

}  // namespace unibody
