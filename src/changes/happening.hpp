// Events of a scene, at the start of a frame.
#pragma once

#include "changes/changes.hpp"

namespace unibody {

// Does what the events that happen at the start of this frame want done, in the order of the scene. Collective.
Changed happen(Simulation& simulation, Scene& scene, std::int64_t frame);

}  // namespace unibody
