// Restitution: the speeds at which impacts throw bodies back (Newton's hypothesis, point by point).
#pragma once

#include "collide/collide_settings.hpp"
#include "collide/contacts.hpp"
#include "world/world.hpp"

namespace unibody {

// Sets contacts.bounce, and `bounce` of the contacts of surfaces. A point bounces off at e times the speed at which the bodies
// approach there at the step's start, if they touch within the step at that speed and if it is more than weight can have given a
// resting body: 2 |g| h. Slower ones stay. It is the most: ContactBatch::limit_bounces.
void set_bounces(const World& world, const CollideSettings& settings, Contacts& contacts);

}  // namespace unibody
