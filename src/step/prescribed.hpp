// What the scene gives in time: velocities of kinematic bodies and of surfaces, gravity, friction, and forces and torques on
// dynamic bodies.
#pragma once

#include "step/rank_state.hpp"

namespace unibody {

// Gives them the mean velocities of the step that is to be taken, on every rank: it then ends where the scene says that they are.
// Before contacts are sought for.
void set_prescribed_velocities(RankState& state);

// Sets gravity, the coefficients of friction and the motions of surfaces to their means over the step that is to be taken. Before
// contacts are sought for.
void set_loads(RankState& state);

// A home's or guest's properties with the mean force and torque of the step that is to be taken: its velocity then ends at the
// integral of what acts on it.
BodyProperties properties_in_step(const RankState& state, std::size_t slot);

// Adds to the predicted velocities (m/s) of home bodies what the forces on parts of solids that change in time do in the step.
void push_on_parts(const RankState& state, std::span<SolverBody> bodies);

}  // namespace unibody
