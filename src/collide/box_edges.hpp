// Two boxes that lean against each other with edges that run along each other, as two cards do.
#pragma once

#include "collide/box_box.hpp"

namespace unibody {

// Where two parallel edges meet, within 0.3 of the smallest half edge, and no two faces lie on each other, every direction
// between the faces about them separates the boxes as well as another, and the test of axes would take a face of one of the two,
// by rounding. The normal is then half way between the edges' own directions, outwards over their two faces: what rounded edges
// would have, and the same for both. Edges that pass each other by more than they are rounded have the direction from one to the
// other, and where that is not between the faces the boxes are apart by a face. False where no such edges meet. In planar scenes
// edges are along y, and a point is one.
bool manifold_of_meeting_edges(const Proxy& a, const Proxy& b, const BoxRelation& relation, bool planar, double margin,
                               PairManifold& out);

}  // namespace unibody
