// Assembling a step: the predicted velocities, and the batches of all constraints over them.
#pragma once

#include <vector>

#include "step/rank_state.hpp"

namespace unibody {

// What batches are built from, as a rank has it now. The state and the system must outlive it.
BuildContext build_context(RankState& state, const System& system);

// v~ = v + h W f, into the system's bodies: of homes, and of guests as well, from the same states to the same bits. What the air
// and the attraction of what touches do comes on top, for homes alone; assemble() tells the guests.
void predict(const RankState& state, System& system);

// Lays out this step's constraints: by colour for Gauss-Seidel, in key order for the Jacobi solvers, whose sums per body follow
// it. geometric_stiffness: see steadying.hpp; empty: no joints. What it corrects of the prediction of homes (edge_crossing.hpp)
// facts_of() tells the guests. Collective.
void assemble(RankState& state, System& system, std::span<double> geometric_stiffness);

// What the plan needs to know of the step. After the warm start's multipliers of the constraints have been set. Collective.
StepFacts facts_of(const RankState& state, System& system);

// q = q_l (+) h v for home bodies, and for kinematic ones on every rank.
void finalise(RankState& state, const System& system);

}  // namespace unibody
