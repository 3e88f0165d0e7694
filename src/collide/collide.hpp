// Collision detection: bodies in, contacts out. Stateless; the result depends on the pair alone, never on rank or history.
#pragma once

#include <functional>

#include "collide/contacts.hpp"
#include "world/world.hpp"

namespace unibody {

struct CollideSettings {
  double step = 0.016;                  // s, the time ahead for which contacts are made
  double margin = 0.002;                // m, eps of the margin rule
  Vec3 gravity = Vec3::Zero();          // m/s^2
  bool planar = false;
  std::vector<double> friction{0.5};    // n x n by material
  std::size_t material_count = 1;
};

// A body's axis-aligned bounds (m), grown by all that it can travel or reach in a step. Two bodies whose swept bounds are
// disjoint have no contact; this is also what decides which ranks a body visits as a guest.
struct Bounds {
  Vec3 lower, upper;
};
Bounds swept_bounds(const World& world, std::size_t slot, const CollideSettings& settings);

// Finds all contacts of pairs with at least one home body (dynamic); pairs of two guests, of two statics, or of a guest and a
// static are left out. `contacts` is overwritten: manifolds in ascending (id_a, id_b), points in ascending feature.
void collide(const World& world, const CollideSettings& settings, Contacts& contacts);

}  // namespace unibody
