// Restitution: the speeds at which impacts throw bodies back (Newton's hypothesis, point by point).
#pragma once

#include <cstdint>
#include <span>

#include "collide/collide_settings.hpp"
#include "collide/contacts.hpp"
#include "world/world.hpp"

namespace unibody {

// A body's velocities before its bounces, to which its energy belongs.
struct BounceStart {
  Vec3 velocity, spin;  // m/s, rad/s: at the step's start, changed by what impacts within the step gave (step/impacts.hpp)
  Vec3 left_out;        // rad/s: what the solver's spin, the mean one of the step, is short of; 0 where all moments are equal
};

// Sets contacts.bounce, and `bounce` of the contacts of surfaces. A point bounces off at e times the speed at which the bodies
// approach there at the step's start, if they touch within the step at that speed and if it is more than weight can have given a
// resting body: 2 |g| h. Slower ones stay. It is the most: ContactBatch::limit_bounces.
void set_bounces(const World& world, const CollideSettings& settings, Contacts& contacts);

// The same once more for contacts of bodies whose velocities impacts have changed, but for those of `settled` manifolds (by
// number), which are these impacts'. starts: of each slot.
void renew_bounces(const World& world, const CollideSettings& settings, std::span<const BounceStart> starts,
                   std::span<const std::uint8_t> settled, Contacts& contacts);

}  // namespace unibody
