// Build: from the scene's generators to this rank's first World.
#pragma once

#include <mpi.h>

#include "scene/scene.hpp"
#include "world/world.hpp"

namespace unibody {

// This rank's share of the moving bodies, by number alone, and all statics. No rank makes a body that it does not keep.
World build_world(MPI_Comm comm, const Scene& scene);

// Every constraint of the scene that touches one of this rank's home bodies.
ConstraintSet build_constraints(const Scene& scene, const World& world);

// The bodies of other ranks that constraints tie to this rank's, ascending. `world` has no guests yet.
std::vector<Id> partners(const World& world, const ConstraintSet& constraints);

// Pins and releases the bodies that are here, as the scene has them at this time (s). A node held by a kinematic body gets the
// velocity that takes it to its point of that body in the step (s) to come; released, it keeps its last one.
void hold_pinned(const Scene& scene, World& world, double time, double step);

}  // namespace unibody
