// Warm start: which of the last step's multipliers a contact point starts from.
#pragma once

#include <span>

#include "collide/contacts.hpp"
#include "constraints/contact_batch.hpp"
#include "constraints/multipliers.hpp"
#include "world/world.hpp"

namespace unibody {

// Sets the impulses (N s, in each point's own frame) for a step of `step` s: `share` times those of the same pair's nearest
// remembered point, in the frame of the body that carries it; each old point serves once. The friction
// force of two bodies that turn together is turned along with them (carried.hpp). The result depends on the pair's points alone,
// not on the order of the pairs or on the rank.
void recall(const Multipliers& multipliers, const World& world, const Contacts& contacts, double step,
            std::span<ContactBatch::Impulse> impulses, double share = 1);

// The other way: what to remember of these impulses. Either of all points at once, or first of nothing, with room for the
// contacts that there are, and then of each manifold in order.
void start_remembering(Multipliers& multipliers, const Contacts& contacts);
// Whether the manifold is remembered: all are but those of cores beside the one point of a round body.
bool is_remembered(const World& world, const Contacts& contacts, const Manifold& manifold);
void remember_manifold(Multipliers& multipliers, const World& world, const Contacts& contacts, const Manifold& manifold,
                       std::span<const ContactBatch::Impulse> of_manifold, double step);
void remember(Multipliers& multipliers, const World& world, const Contacts& contacts,
              std::span<const ContactBatch::Impulse> impulses, double step);

}  // namespace unibody
