// How stiff a scene's constraints are for its time step, and how far it takes their bodies: what the total form depends on.
#pragma once

#include "scene/scene.hpp"

namespace unibody {

// The largest h^2 D^T W D / E of a row of any constraint beside contacts at the start: 1 where a constraint's own stiffness
// weighs as much as the masses at its ends in a step of h; infinite where one has no compliance; 0 where there is none.
double stiffness_number(const Scene& scene);
// The same of these tetrahedra of solids, as far as it is at most `enough`; else more than that.
double stiffness_number(const Scene& scene, const ConstraintSet& constraints, double enough);

// The largest h |v_a - v_b| / |x_a - x_b| over the ends of the mesh's edges at the start, where v are the velocities that bodies
// have after a step h of free motion; nodes that other bodies hold are left out. 0 where there is none.
double edge_motion(const Scene& scene);

// Above it the Jacobi solvers are known to diverge in the total form: a cantilever of tetrahedra of edge l thrown into rotation
// with h v / l = 0.64 at its tip converges at 31 and not at 94; with 0.13, at 313 and not at 3,100.
inline constexpr double stiffest_for_total = 30;

}  // namespace unibody
