// Neighbours: which of this rank's bodies come near bodies of another rank.
//
// Space is cut into cells of about a body's size, and those into blocks of some cells a side. A rank tells a directory, spread
// over all ranks, which blocks its bodies touch, and hears who else touches them; with these, its neighbours, it compares cells.
// So what a rank sends grows with its own bodies and neighbours, not with the number of ranks, and a single body that has gone
// far makes nobody a neighbour who is not there. Bodies that touch very many blocks are told to all.
#pragma once

#include <mpi.h>

#include <span>

#include "collide/broadphase.hpp"
#include "partition/messages.hpp"

namespace unibody {

struct CellSizes {
  double cell = 1;                // m, edge of a cell: any, the same on every rank; it sets the price alone
  std::int64_t cells_a_side = 1;  // of a block
};

// Collective. By rank: the bodies, ascending, whose bounds may overlap those of one of that rank's bodies. bounds: in any order,
// and as many as it has images for a body; of: the body that each belongs to. Bounds that overlap are always found; some that
// only come within a cell of each other are too.
ListsByRank<std::int32_t> bodies_near_ranks(MPI_Comm comm, std::span<const Bounds> bounds, std::span<const std::int32_t> of,
                                            const CellSizes& sizes);

}  // namespace unibody
