// Friction that is larger at rest than in motion: mu (1 + stiction exp(-v / stiction_speed)), with mu the coefficient of two
// materials and v the speed at which they slide on each other at the start of the step (m/s), less the motion of their surfaces.
// (Stribeck's curve without its viscous part; Armstrong-Helouvry, Dupont, Canudas de Wit, Automatica 30, 1994, 1083.)
#pragma once

#include "collide/collide_settings.hpp"
#include "collide/contacts.hpp"
#include "world/world.hpp"

namespace unibody {

// Raises the coefficients of contacts, which are those in motion. What any rank finds for a contact is the same to the last bit.
void add_stiction(const World& world, const CollideSettings& settings, Contacts& contacts);

}  // namespace unibody
