// Closed mesh shapes: whether they are solids, or containers.
#pragma once

#include <mpi.h>

#include <string>
#include <vector>

#include "scene/scene.hpp"

namespace unibody {

// Which way the triangles of a closed surface turn says nothing of what it is for: programs that draw containers turn them
// outwards. So a surface that asks for it (sides: auto) is touched from where dynamic bodies start: a body is behind it that is
// all behind. Where all of them are, it is turned over; where some are and some are in front, it is touched from both sides.
// Says so in `notes`, one line a surface. Collective; the same on all ranks, and at a restart the same as at the start.
void decide_mesh_sides(MPI_Comm comm, const Scene& scene, std::vector<std::string>& notes);

}  // namespace unibody
