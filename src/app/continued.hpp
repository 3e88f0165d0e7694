// How a scene starts from where another scene's bodies are: those of a checkpoint, matched by name and number.
#pragma once

#include <mpi.h>

#include <string>
#include <vector>

#include "checkpoint/checkpoint_outline.hpp"
#include "scene/scene.hpp"
#include "step/simulation.hpp"

namespace unibody {

SceneOutline outline_of(const Scene& scene);

// Makes the world of a scene whose bodies start as they are in the checkpoint at `path`, where that has them: body k of an entry
// as body k of the entry of the same name. Place, orientation and velocities of those that can move are the checkpoint's; all
// else, and all bodies that the checkpoint does not have, are as the scene says, and what it has beside them is left out. Bodies
// of such an entry that had left before the checkpoint are absent, and its inlet lets nothing more in. Time starts at 0, and
// contacts and joints without forces.
// Returns what is told of it, a sentence for each entry that differs. Throws InputError where the file is damaged, where no entry
// has a name that it knows, or where a joint or a constraint would hold bodies together of which only some go on. Collective.
std::vector<std::string> continue_from(MPI_Comm comm, const std::string& path, Scene& scene, Simulation& simulation);

}  // namespace unibody
