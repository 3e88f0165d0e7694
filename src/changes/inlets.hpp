// Inlets of a scene, at the start of a frame.
#pragma once

#include "changes/changes.hpp"

namespace unibody {

// Puts bodies that are due into the world where they overlap nothing that is there; those that find no room wait. Returns whether
// one came in. Collective.
bool let_in(Simulation& simulation, std::int64_t frame);

}  // namespace unibody
