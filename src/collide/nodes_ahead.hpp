// Nodes of surfaces that lie ahead of a body which moves along the surface.
#pragma once

#include "collide/collide_settings.hpp"
#include "collide/contacts.hpp"
#include "collide/surfaces.hpp"

namespace unibody {

// A node touches bodies as a ball of its surface's thickness. Where a body slides along a flat cloth, the ball of the next node
// stands in its way, though the cloth between the nodes is as high: across the distance of the two lies a plane that leans over
// the node's neighbours, and the body runs into it. Leaves out such contacts: those of nodes that
// the body does not touch yet, but would by what it moves along its distance to the node, while it hardly moves along the nearest
// direction that leans over no neighbour. What lies between the nodes has contacts of its own. In a surface that curves towards
// the body all directions lean: there nothing is left out.
void leave_out_nodes_ahead(const World& world, const Surfaces& surfaces, const CollideSettings& settings, Contacts& contacts);

}  // namespace unibody
