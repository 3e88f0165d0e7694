// World: this rank's bodies as arrays. A slot is an index into all of them.
//
// Slots [0, homes) are home bodies, whose motion this rank computes; [homes, homes + guests) are copies of other ranks'
// bodies that can touch them; the rest are statics (fixed and kinematic bodies), replicated on every rank.
// Each of the three ranges is in ascending order of id. The first is covered by the PETSc Vecs of the global state.
#pragma once

#include <algorithm>
#include <vector>

#include "world/friction_axes.hpp"
#include "world/period.hpp"
#include "world/properties.hpp"
#include "world/surface_motion.hpp"

namespace unibody {

struct World {
  std::size_t homes = 0, guests = 0;
  Period period;              // of the scene
  bool has_rotations = true;  // false: nothing turns, and the two arrays of rotation are empty

  std::vector<Id> id;
  PropertyTable properties;
  std::vector<Vec3> position;          // m
  std::vector<Quat> orientation;       // body -> world, unit
  std::vector<Vec3> velocity;          // m/s
  std::vector<Vec3> angular_velocity;  // rad/s, world frame
  SurfaceMotions surface_motions;      // over the next step; of whole runs of bodies, whether or not they are here
  FrictionAxes friction_axes;          // the same
  std::vector<Quat> held_orientation;  // of statics, from first_static() on, where nothing turns; else empty

  std::size_t size() const { return id.size(); }
  std::size_t first_static() const { return homes + guests; }
  bool is_home(Slot slot) const { return static_cast<std::size_t>(slot) < homes; }
  bool is_static(Slot slot) const { return static_cast<std::size_t>(slot) >= first_static(); }

  // The slot of a body; -1 where it is not on this rank.
  Slot find(Id body) const {
    const std::size_t ends[] = {0, homes, first_static(), size()};
    for (int range = 0; range < 3; ++range) {
      const auto begin = id.begin() + static_cast<std::ptrdiff_t>(ends[range]);
      const auto end = id.begin() + static_cast<std::ptrdiff_t>(ends[range + 1]);
      if (begin == end || body < *begin) continue;
      if (const Id offset = body - *begin; offset < end - begin && begin[offset] == body)  // most runs of ids have no gap
        return static_cast<Slot>(begin - id.begin() + offset);
      const auto it = std::lower_bound(begin, end, body);
      if (it != end && *it == body) return static_cast<Slot>(it - id.begin());
    }
    return -1;
  }

  Quat orientation_of(std::size_t slot) const {
    if (has_rotations) return orientation[slot];
    return slot < first_static() ? Quat::Identity() : held_orientation[slot - first_static()];
  }
  Vec3 angular_velocity_of(std::size_t slot) const { return has_rotations ? angular_velocity[slot] : Vec3(Vec3::Zero()); }
  BodyState state(std::size_t slot) const {
    return {position[slot], orientation_of(slot), velocity[slot], angular_velocity_of(slot)};
  }
  void set_state(std::size_t slot, const BodyState& s) {
    position[slot] = s.position, velocity[slot] = s.velocity;
    if (has_rotations)
      orientation[slot] = s.orientation, angular_velocity[slot] = s.angular_velocity;
    else if (slot >= first_static())
      held_orientation[slot - first_static()] = s.orientation;
  }
  Body body(std::size_t slot) const { return {id[slot], properties[slot], state(slot)}; }

  // After `homes` and `guests` are set.
  void resize(std::size_t n) {
    id.resize(n), properties.resize(n), position.resize(n), velocity.resize(n);
    if (has_rotations)
      orientation.resize(n), angular_velocity.resize(n);
    else
      held_orientation.resize(n - first_static(), Quat::Identity());
  }
  void set(std::size_t slot, const Body& b) {
    id[slot] = b.id, properties.set(slot, b.properties);
    set_state(slot, b.state);
  }
};

// A world of these home bodies and statics, each in ascending id; no guests yet.
inline World make_world(const std::vector<Body>& homes, const std::vector<Body>& statics, bool has_rotations = true,
                        const Period& period = {}) {
  World world;
  world.period = period;
  world.has_rotations = has_rotations;
  world.homes = homes.size();
  world.resize(homes.size() + statics.size());
  for (std::size_t i = 0; i < homes.size(); ++i) world.set(i, homes[i]);
  for (std::size_t i = 0; i < statics.size(); ++i) world.set(homes.size() + i, statics[i]);
  return world;
}

}  // namespace unibody
