// The part of a checkpoint that scenes with cloths and threads have: the multipliers of their constraints.
#pragma once

#include <mpi.h>

#include <cstdint>

#include "constraints/constraint_types.hpp"
#include "core/hdf5.hpp"
#include "world/world.hpp"

namespace unibody {

// The rows of one type: a constraint stands where the id block of its first moving body is, in order of that body, then of ids.
template <class C>
struct ConstraintRow {
  Id owner;
  std::array<Id, C::stencil> ids;
  std::array<double, C::rows> multipliers;  // N s
};
template <class C>
using ConstraintRowList = std::vector<ConstraintRow<C>>;
using ConstraintRows = ConstraintTypes::Tuple<ConstraintRowList>;

// This rank's share of the file's rows. Collective.
ConstraintRows constraint_rows(MPI_Comm comm, Id body_count, const World& world, const ConstraintSet& constraints,
                               const ConstraintMultipliers& multipliers);

// Writes group `constraints`, of the types that the scene has; false: the disk fails. Collective.
[[nodiscard]] bool write_constraint_rows(MPI_Comm comm, hid_t file, const ConstraintRows& rows);

// The multipliers of the constraints that are here. Each rank reads all rows of the file, a piece at a time. Throws
// std::runtime_error where a table is not what it should be.
ConstraintMultipliers read_constraint_multipliers(hid_t file, const ConstraintSet& constraints);

}  // namespace unibody
