// Outlets of a scene, at the start of a frame.
#pragma once

#include "changes/changes.hpp"

namespace unibody {

// Takes the bodies in outlets out of the world, each counted by the first outlet that it is in. Returns whether there was one.
// Collective.
bool let_out(Simulation& simulation);

}  // namespace unibody
