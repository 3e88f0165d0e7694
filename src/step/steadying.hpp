// Steps that are taken again: with light bodies between strong joints, which the step does not resolve, and of edges that move
// too far for the total form.
//
// Light bodies between strong joints turn back so fast that the step does not resolve it, and is steadied for it:
// h^2 K > I, with K the geometric stiffness of the joints' forces on a body and I its inertia: an iteration that takes these
// forces along directions of its own would make the body spin. As in Andrews et al. (Geometric stiffness for real-time
// constrained multibody dynamics, 2017) such a body's inertia against constraints is raised, here until h^2 K = I; resolved
// motion is as it was. K is that of the last step's forces, and the step is taken again where its own turn out much larger.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "step/rank_state.hpp"

namespace unibody {

// h^2 K of each slot (kg m^2), by the last step's impulses of the joints: right for home bodies, whose joints are all here.
std::vector<double> geometric_stiffness_of_joints(const RankState& state);

// Raises the inertia of the bodies that turn too fast. geometric_stiffness: h^2 K, of
// home bodies; that of guests is filled in. Collective.
void steady_by_stiffness(RankState& state, System& system, std::span<double> geometric_stiffness);

// Takes the step, by `attempt`, and again for the step's own forces where they turned bodies faster than it was steadied for; at
// an impact they come from nothing. geometric_stiffness: as the last step has left it; raised. Collective.
void take_steadily(RankState& state, System& system, std::vector<double>& geometric_stiffness,
                   const std::function<void()>& attempt);

// What a step starts from; and back to it, with an empty system.
StepOrigin origin_of(const RankState& state);
void go_back(RankState& state, System& system, const StepOrigin& origin);

// The form in which the constraints between centres are solved from now on.
void set_form(RankState& state, System& system, Form form);

// Whether, in the total form, the ends of an edge move too far against each other anywhere for it to converge. Collective.
bool leaves_total_form(const RankState& state, const System& system);

}  // namespace unibody
