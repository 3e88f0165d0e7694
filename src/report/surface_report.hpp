// What a frame with surfaces is judged by besides: whether anything went through them.
#pragma once

#include <mpi.h>

#include "collide/surfaces.hpp"

namespace unibody {

// Edges that go through faces (crossings.hpp), of surfaces that may touch each other, over all ranks. Collective.
std::int64_t count_crossings(MPI_Comm comm, const World& world, const Surfaces& surfaces);

}  // namespace unibody
