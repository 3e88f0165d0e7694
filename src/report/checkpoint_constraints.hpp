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

// A sum of hashes, the same in any order.
std::uint64_t sum_of_hashes(const ConstraintRows& rows);

// Writes group `constraints`, of the types that the scene has; false: the disk fails. Collective.
[[nodiscard]] bool write_constraint_rows(MPI_Comm comm, hid_t file, const ConstraintRows& rows);

// This rank's share of what the file holds, and the multipliers of the constraints that are here. Each rank reads all rows, a
// piece at a time. Throw std::runtime_error where the file is damaged.
ConstraintRows read_constraint_rows(MPI_Comm comm, hid_t file);
ConstraintMultipliers read_constraint_multipliers(hid_t file, const ConstraintSet& constraints);

}  // namespace unibody
