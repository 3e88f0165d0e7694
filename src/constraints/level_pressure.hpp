// Where faces lie on each other with a rim and an inner ring of points (collide/face_patch.hpp), how the load is shared out
// between the two does not follow from the bodies' motion: any sharing with the same force and moment moves them the same way,
// but friction resists spinning more the further out the load is. It belongs to the inner ring, with the pressure a linear
// function of the place, as of elastic faces. Iterations that have much to mend would move it out again: friction, whose
// direction turns with the faces, therefore starts as the velocities say.
#pragma once

#include <span>

#include "collide/contacts.hpp"
#include "constraints/contact_batch.hpp"
#include "constraints/multipliers.hpp"
#include "world/world.hpp"

namespace unibody {

// Gives the impulses (N s, of each of the contacts' points) with which pairs with inner rings start that distribution along the
// normal, with the same force and moment, and friction against the bodies' velocities, as far as it does not stop them within the
// step. They stay as they are where that would pull somewhere.
// `scale` times the forces of the history is what they were recalled from: what points of such a pair had that are no more goes
// to those that are.
void level_pressure(const Multipliers& history, const World& world, const Contacts& contacts, double scale,
                    std::span<ContactBatch::Impulse> impulses);

}  // namespace unibody
