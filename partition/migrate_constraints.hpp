// Constraints are made anew wherever their bodies go; only their multipliers travel.
#pragma once

#include <mpi.h>

#include <span>

#include "constraints/constraint_types.hpp"
#include "world/world.hpp"

namespace unibody {

// The multipliers of a constraint on their way.
template <class C>
struct ConstraintRecord {
  std::array<Id, C::stencil> ids;
  std::array<double, C::rows> multipliers;
};
template <class C>
using RecordsByRank = std::vector<std::vector<ConstraintRecord<C>>>;
using ConstraintRecords = ConstraintTypes::Tuple<RecordsByRank>;

// Before the bodies go: what has to be sent, by rank. home: where each home body goes.
ConstraintRecords constraint_records(const World& world, const ConstraintSet& constraints,
                                     const ConstraintMultipliers& multipliers, std::span<const int> home, int ranks);

// When the new constraints are there: the multipliers of each, 0 where nothing is known of one. Collective.
ConstraintMultipliers take_constraint_records(MPI_Comm comm, const ConstraintSet& constraints, ConstraintRecords records);

// The bodies of other ranks that constraints tie to this rank's, ascending. `world` has no guests yet.
std::vector<Id> partners(const World& world, const ConstraintSet& constraints);

}  // namespace unibody
