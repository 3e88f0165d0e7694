// One number that tells whether two runs ended in the same state, bit for bit.
#pragma once

#include <mpi.h>

#include <cstdint>

#include "world/world.hpp"

namespace unibody {

// 64-bit hash of the states (13 doubles) of all bodies, by id. Equal on any number of ranks, for any partition. Collective.
std::uint64_t state_hash(MPI_Comm comm, const World& world);

}  // namespace unibody
