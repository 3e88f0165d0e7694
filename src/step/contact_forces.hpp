// What contacts did in a step, for those who measure forces. Asking for it changes nothing in the step.
//
// The impulses are the multipliers of both stages together, and those of impacts that were resolved before the solve. By them, by
// gravity and by the scene's loads the momentum of bodies changes; what the solve leaves undone is in neither of them. Not
// included: what pins and joints do, what is held by the surfaces' guard (surface_guard.hpp) and friction that is done after the
// solve (solver.friction: postprocess).
#pragma once

#include <vector>

#include "collide/contacts.hpp"
#include "step/contact_impulse.hpp"
#include "world/world.hpp"

namespace unibody {

struct RankState;
struct System;

// Adds what two bodies do to each other at a point (m): an impulse (N s) on the first, unless it is zero.
void add_impulse(const World& world, const Manifold& manifold, const Vec3& point, const Vec3& normal, const Vec3& impulse,
                 std::vector<ContactImpulse>& out);

// The impulses of a step at the points of contact of this rank, those of zero left out. Each point of contact belongs to one rank
// alone. To be called after the last stage of a step, before the bodies are moved. Not collective.
std::vector<ContactImpulse> contact_impulses(const RankState& state, const System& system);

}  // namespace unibody
