// What a frame is judged by: penetration, energy, momentum. The same bits on any number of ranks.
#pragma once

#include <mpi.h>

#include "collide/contacts.hpp"
#include "world/material_pairs.hpp"
#include "world/world.hpp"

namespace unibody {

struct Measures {
  // One depth a pair, that of its deepest point; the root mean square is over the pairs that penetrate.
  double penetration_max = 0, penetration_rms = 0, penetration_l2 = 0;  // m; l2: root of the sum of squares
  std::int64_t pairs = 0, contacts = 0;  // pairs with a manifold and contacts of surfaces; points, also open

  // Of the dynamic bodies.
  double kinetic_energy = 0;             // J
  double potential_energy = 0;           // J, -m g.x
  double elastic_energy = 0;             // J, as elastic_energy() has it; measure() leaves it
  Vec3 linear_momentum = Vec3::Zero();   // kg m/s
  Vec3 angular_momentum = Vec3::Zero();  // kg m^2/s, about the origin

  double bytes_per_body = 0;         // of all ranks' `bytes_here`
  double bytes_of_largest_rank = 0;  // the most of them
};

// `bytes_here`: what this rank's arrays occupy (of bodies, contacts, solver, halo). Pairs of `materials` whose contacts give way
// (constraints/compliance.hpp) are meant to overlap, and count as pairs that do not penetrate. Collective.
Measures measure(MPI_Comm comm, const World& world, const Contacts& contacts, const Vec3& gravity, double bytes_here = 0,
                 const MaterialPairs* materials = nullptr);

// Whether all numbers of a state are finite, and the place and the speed within the limits of world/limits.hpp.
bool is_sound(const BodyState& state);

// The smallest id whose state is not sound; -1: none. Collective.
Id first_bad_body(MPI_Comm comm, const World& world);

}  // namespace unibody
