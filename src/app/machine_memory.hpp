// The memory that a run may use, and what happens where it is not enough.
#pragma once

#include <mpi.h>

#include "scene/scene.hpp"

namespace unibody {

// The memory of each machine shared among its ranks; the least share counts, as all ranks make as many bodies. Collective.
Room room_of(MPI_Comm comm);

// Where memory runs out on one rank from now on, that rank says so, with the number of the scene's bodies (0: not known yet), and
// ends the run where it stands.
void end_run_out_of_memory();
void tell_bodies_in_scene(long long bodies);

}  // namespace unibody
