// Seams: several convex solids whose faces lie in one plane, as tiles of a floor, bricks of a wall, parts of a compound.
//
// A body that slides over them touches one solid and comes near the side of the next, which no one can touch: it lies behind the
// flush faces. The pair alone cannot know; a third body tells. Where the body touches that third one, their contact keeps it
// above a plane. A solid that lies wholly behind this plane cannot be met with any other normal, as long as the contact holds,
// and it holds for the step: so the contact with the solid takes the plane's normal.
#pragma once

#include <vector>

#include "collide/known_contacts.hpp"
#include "collide/narrowphase.hpp"

namespace unibody {

// Whether a manifold may be one with the hidden side of a solid: its nearest point lies in the plane of a face that is not the
// one its normal belongs to, and the other solid lies on that face's outer side. A matter of the pair alone.
bool may_be_at_seam(const PairManifold& manifold, const CollideSettings& settings);

// Corrects a manifold that may lie at a seam. Where a plane hides one of the two solids, the manifold takes the normal of that
// plane, or loses its points where that plane's own contact says all. `thirds`: bodies that may touch both, in ascending id, a
// compound of the pair included; their contacts are asked of `known`. Parts and positions as in what collide_parts() hands out.
void mend_at_seam(PairManifold& manifold, const std::vector<const Proxy*>& thirds, const CollideSettings& settings,
                  KnownContacts& known);

}  // namespace unibody
