// Which of two bodies in contact carries their point of contact along, where the two slide past each other.
#pragma once

#include "collide/contacts.hpp"
#include "world/world.hpp"

namespace unibody {

// The share of the manifold's first body in the motion of a contact point along the surfaces: a corner, an edge or a round side
// takes it along over a flat one. Of two alike, or that are both flat, the one that moves does; of two that move, each half.
double share_of_first(const World& world, const Manifold& m, const ContactPoint& point);

}  // namespace unibody
