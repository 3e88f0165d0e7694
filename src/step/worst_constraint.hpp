// Which constraint of a step is farthest from solved.
#pragma once

#include <mpi.h>

#include <array>
#include <limits>
#include <string_view>

#include "core/types.hpp"

namespace unibody {

struct System;
struct World;

struct WorstConstraint {
  static constexpr Id none = std::numeric_limits<Id>::max();

  double residual = -1;                                 // m, its natural residual; negative: there is no constraint
  std::string_view kind;                                // the name of its batch
  Id place = none;                                      // of the batch in the list of all
  std::array<Id, 4> bodies = {none, none, none, none};  // ids of those that it ties, ascending, then `none`

  // Whether this one is named rather than the other: it is farther from solved, or as far and comes first in an order that no
  // rank's layout has a part in.
  bool precedes(const WorstConstraint& other) const {
    if (residual != other.residual) return residual > other.residual;
    return place != other.place ? place < other.place : bodies < other.bodies;
  }
};

// The worst of this rank's constraints that act in the stage that was run last. Takes a pass over all of them.
WorstConstraint worst_constraint(const System& system, const World& world);

// The worst constraint of all ranks. Collective.
WorstConstraint worst_over_ranks(MPI_Comm comm, const WorstConstraint& here);

}  // namespace unibody
