// Friction after the solve, as in position-based dynamics (Mueller et al. 2007): for comparison with friction within it alone.
//
// Places come from a solve without friction. Then, once, each contact that pressed takes from the velocity v_T of its slip
// min(mu lambda_n w, |v_T|), w the inverse mass that it feels along v_T. All contacts act at once, by masses split among those of
// a body: the kinetic energy cannot grow, and neither their order nor the rank matters. What should stick moves in every step by
// what the forces of one step do to it.
#pragma once

#include <cstdint>
#include <span>

#include "collide/contacts.hpp"
#include "solve/solver.hpp"
#include "world/world.hpp"

namespace unibody {

// Brakes the velocities of system.bodies and keeps those of the solve, with which bodies move, in system.moving. Returns the
// number of counted contacts that slide on. Collective.
std::int64_t postprocess_friction(const World& world, const Contacts& contacts, System& system, const Exchange& exchange);

}  // namespace unibody
