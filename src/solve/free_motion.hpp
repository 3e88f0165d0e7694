// A body's motion apart from constraints: the prediction before the solve and the update of position after it.
//
// Spin (Simo & Wong 1991): the torque-free part is the implicit midpoint rule in the body frame, which keeps the
// energy and the magnitude of the angular momentum exactly; with the normalised quaternion update (a Cayley map) it keeps the
// momentum's direction in space as well. The solver then works at the inertia of the start of the step.
//
// Impulses add to the mean spin, by which the body turns; its new momentum in the attitude that it so gets may be worth more
// energy than before: a thin rod, whose inertia about its length is small, would spin up without end. Where a step would gain
// energy by turning, or turns a body by more than a radian, the body turns as with its new momentum it would freely. So does a
// body without joints that turns by more than a fifth of one, in parts of a twentieth, so that it keeps its phase.
#pragma once

#include "constraints/solver_body.hpp"
#include "world/body.hpp"

namespace unibody {

struct FreeMotion {
  SolverBody body;                 // v~ and w~, inverse mass; w~ is the mean spin over the step
  InverseInertia inverse_inertia;  // world frame, at the start of the step; where not isotropic
  bool isotropic;
  Vec3 gyroscopic;  // kg m^2/s: I w - I w~ before torque, what the mean spin leaves out of the momentum
};

// The inverse inertia in the world's axes of a body with these inverse principal moments (1/(kg m^2)).
InverseInertia inverse_inertia(const Quat& orientation, const Vec3& inverse_moments);

FreeMotion predict_motion(const BodyProperties& body, const BodyState& state, const Vec3& gravity, double step, bool planar);

// The turn by a rotation vector: its direction the axis, its length the angle (rad).
Quat turn_by(const Vec3& rotation);

// An orientation after a step of rotation at `spin` (rad/s, world axes).
Quat turned_by(const Quat& orientation, const Vec3& spin, double step);

// The turn of a body whose motion is given, which is exact; turned_by() turns by a little less, 2 atan(h w / 2).
Quat driven_turn(const Vec3& spin, double step);

// A body that turns freely for a step, from its spin (rad/s) in an attitude. `moments`: of inertia, principal (kg m^2).
struct FreeTurning {
  Vec3 mean;        // rad/s, over the step; of one that turns by more than a radian the spin itself
  Vec3 gyroscopic;  // kg m^2/s: I spin - I mean
};
FreeTurning free_turning(const Vec3& moments, const Quat& orientation, const Vec3& spin, double step);

// The orientation of a body that turns freely with this angular momentum (kg m^2/s, world axes) for a step, or back, where the
// step is negative: then it is led to where it comes from.
Quat turned_freely(const Quat& orientation, const Vec3& momentum, const Vec3& moments, double step);

// The state after the step, from the velocities that the solver left. `moving`: those that it moves with, where they differ.
// free: no row was solved for the attitude that a single map leads to.
BodyState finish_motion(const BodyProperties& body, const BodyState& state, const SolverBody& moving, const SolverBody& solved,
                        const Vec3& gyroscopic, double step, bool planar, bool free = false);
inline BodyState finish_motion(const BodyProperties& body, const BodyState& state, const SolverBody& solved,
                               const Vec3& gyroscopic, double step, bool planar) {
  return finish_motion(body, state, solved, solved, gyroscopic, step, planar);
}

}  // namespace unibody
