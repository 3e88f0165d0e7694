// Migration: bodies move to their new homes, and the multipliers remembered of their contacts move with them.
#pragma once

#include <mpi.h>

#include <span>

#include "constraints/multipliers.hpp"
#include "world/world.hpp"

namespace unibody {

// Collective. home[i] is the new home rank of home body i. On return the world's homes are in ascending id; it has no guests.
void migrate(MPI_Comm comm, World& world, Multipliers& multipliers, std::span<const int> home);

// The multipliers in `all` of pairs with a home body in `world`, without repeats, in key order.
Multipliers keep_own(const World& world, const Multipliers& all);

}  // namespace unibody
