// What is asked of all constraints between bodies' centres, of whatever type.
#pragma once

#include <memory_resource>
#include <span>

#include "solve/batches.hpp"

namespace unibody {

// For each of the first `sharers.size()` bodies, all of whose constraints are here, the factor c_b by which the Jacobi solvers
// divide steps (see direction_sum.hpp). The state's counts are of constraints of all kinds; those of other kinds than these are
// taken to push along any direction.
void find_sharers(const Batches& batches, const SolveState& state, std::span<double> sharers, std::pmr::memory_resource* memory);

// The largest geometric stiffness of the links on this rank, with the multipliers of the last step: see ConstraintBatch.
double geometric_stiffness(Batches& batches, const SolveState& state, const BatchHistories& history);

// Sets the form of all steps that follow, until it is set again or slots move.
void set_form(Batches& batches, Form form, bool of_solids_alone);

// Whether the ends of an edge move against each other, in a step at the present velocities, by more than this share of its length
// at its start, on this rank.
bool moves_beyond(const Batches& batches, double share, const SolveState& state);

}  // namespace unibody
