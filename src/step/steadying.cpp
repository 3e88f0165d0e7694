#include "step/steadying.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "solve/centre_constraints.hpp"
#include "solve/free_motion.hpp"

namespace unibody {

namespace {

// The least moment of inertia about the axes about which a body may turn (kg m^2).
double least_moment(const RankState& state, std::size_t slot) {
  const Vec3& moments = state.world.properties[slot].inertia;
  return state.scene.planar ? moments.y() : moments.minCoeff();
}

// Whether the step's own forces exceed what it was steadied for.
bool turns_too_fast(const RankState& state, std::span<const double> geometric_stiffness, std::span<const double> found) {
  bool here = false;
  for (std::size_t i = 0; i < state.world.homes; ++i)
    if (state.world.properties[i].shape.kind != ShapeKind::particle)
      here |= !(found[i] <= 2 * std::max(geometric_stiffness[i], least_moment(state, i)));
  return state.any_over_ranks(here);
}

bool has_turning_joints(const RankState& state) { return state.traits.has_joints && state.world.has_rotations; }

}  // namespace

std::vector<double> geometric_stiffness_of_joints(const RankState& state) {
  std::vector<double> geometric_stiffness(state.world.size() + 1, 0.0);
  for (std::size_t i = 0; i < state.ties.joints.size(); ++i) {
    const Joint& joint = state.scene.joints[static_cast<std::size_t>(state.ties.joints[i])];
    const Slot ends[2] = {state.ties.joint_slots[i].a, state.ties.joint_slots[i].b};
    for (std::size_t e = 0; e < 2; ++e)
      geometric_stiffness[static_cast<std::size_t>(ends[e])] +=
          state.step() * turning_stiffness(joint, e, state.history.joints()[i]);
  }
  return geometric_stiffness;
}

void steady_by_stiffness(RankState& state, System& system, std::span<double> geometric_stiffness) {
  if (!has_turning_joints(state)) return;
  const World& world = state.world;
  state.exchange.refresh(geometric_stiffness);
  for (std::size_t i = 0; i < world.first_static(); ++i) {
    const double missing = geometric_stiffness[i] - least_moment(state, i);
    SolverBody& body = system.bodies[i];
    if (!(missing > 0) || world.properties[i].shape.kind == ShapeKind::particle) continue;
    if (system.isotropic[i]) {
      body.inverse_inertia /= 1 + missing * body.inverse_inertia;
      continue;
    }
    const Vec3 moments = world.properties[i].inertia + Vec3::Constant(missing);
    system.inertia[i] = state.scene.planar ? InverseInertia{0, 1 / moments.y(), 0, 0, 0, 0}
                                           : inverse_inertia(world.orientation[i], moments.cwiseInverse());
  }
}

void take_steadily(RankState& state, System& system, std::vector<double>& geometric_stiffness,
                   const std::function<void()>& attempt) {
  if (!has_turning_joints(state)) return attempt();
  constexpr int most_repeats = 3;
  const StepOrigin origin = origin_of(state);
  for (int repeats = 0;; ++repeats) {
    attempt();
    const std::vector<double> found = geometric_stiffness_of_joints(state);
    if (repeats == most_repeats || !turns_too_fast(state, geometric_stiffness, found)) return;
    for (std::size_t i = 0; i < found.size(); ++i)
      geometric_stiffness[i] =
          std::isfinite(found[i]) ? std::max(geometric_stiffness[i], found[i]) : std::numeric_limits<double>::max();
    go_back(state, system, origin);
  }
}

StepOrigin origin_of(const RankState& state) { return {state.history, state.world.velocity}; }

// The guard of surfaces and the error estimate work on the world's velocities; in place, since the Vec lies over them.
void go_back(RankState& state, System& system, const StepOrigin& origin) {
  system.clear(&state.scratch);
  std::copy(origin.velocity.begin(), origin.velocity.end(), state.world.velocity.begin());
  state.history = origin.history;
}

void set_form(RankState& state, System& system, Form form) {
  state.rows.form = form;
  set_form(system.batches, form, state.scene.solver.form != Form::total);
}

bool leaves_total_form(const RankState& state, const System& system) {
  return state.rows.form == Form::total && state.traits.has_centre_constraints &&
         state.any_over_ranks(moves_beyond(system.batches, most_edge_motion, system));
}

}  // namespace unibody
