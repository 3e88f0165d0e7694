// Attachments: nodes of cloths and threads that are tied to other bodies, as one step of this rank sees them.
#pragma once

#include <array>
#include <vector>

#include "collide/contacts.hpp"
#include "constraints/attachment_batch.hpp"
#include "scene/scene.hpp"
#include "world/world.hpp"

namespace unibody {

// The attachments to dynamic bodies that hold at this time (s) and of which one end is home here, in the order of the scene.
// The other end must be a guest.
std::vector<AttachedNode> attached_nodes(const Scene& scene, const World& world, double time);

// The node and the body of each attachment of which one end is home here, now or later, ascending. `world` needs no guests.
std::vector<std::array<Id, 2>> attachments_here(const World& world, const std::vector<Attachment>& attachments);

// The bodies of other ranks to which attachments tie this rank's, ascending. Mutual between ranks. `world` needs no guests.
std::vector<Id> partners(const World& world, const std::vector<Attachment>& attachments);

// The body that holds each slot's node at this time (s), static or dynamic; -1: none. Empty where nobody here is held.
std::vector<Id> holders(const Scene& scene, const World& world, double time);

// Takes away the contacts between nodes and the bodies that hold them at this time (s), static or dynamic: a node's own, and
// those of faces, edges and segments in which such a node has a part.
void leave_out_attached(const Scene& scene, const World& world, double time, Contacts& contacts);

}  // namespace unibody
