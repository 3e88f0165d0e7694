#include "step/bounces.hpp"

#include <algorithm>
#include <vector>

#include "collide/restitution.hpp"
#include "step/impacts.hpp"

namespace unibody {

namespace {

// rad/s: the spin to which a body's momentum belongs, less its mean spin over the step (solve/free_motion.hpp).
Vec3 left_out_of_spin(const System& system, std::size_t slot) {
  if (system.isotropic[slot]) return Vec3::Zero();
  return inverse_inertia_of(system.bodies, system.inertia, system.isotropic, slot) * system.gyroscopic[slot];
}

void set_starts(RankState& state, const System& system, std::span<const SolverBody> predicted, std::span<const Vec3> left_out) {
  const World& world = state.world;
  std::vector<BounceStart>& starts = state.impacts.starts;
  starts.assign(world.size() + 1, {Vec3::Zero(), Vec3::Zero(), Vec3::Zero()});
  for (std::size_t i = 0; i < world.size(); ++i) {
    const SolverBody &was = predicted[i], &is = system.bodies[i];
    starts[i] = {world.velocity[i], world.angular_velocity_of(i), Vec3::Zero()};
    if (world.is_static(static_cast<Slot>(i))) continue;
    starts[i].left_out = left_out_of_spin(system, i), starts[i].spin += starts[i].left_out - left_out[i];
    if (std::equal(was.v, was.v + 3, is.v) && std::equal(was.w, was.w + 3, is.w)) continue;
    starts[i].velocity += Eigen::Map<const Vec3>(is.v) - Eigen::Map<const Vec3>(was.v);
    starts[i].spin += Eigen::Map<const Vec3>(is.w) - Eigen::Map<const Vec3>(was.w);
  }
}

// The contacts as they were found: a step may be taken more than once.
void forget_impacts(RankState& state) {
  StepImpacts& impacts = state.impacts;
  for (Manifold& m : state.contacts.manifolds) m.displaced = 0;
  if (!impacts.gaps_found.empty()) {
    for (std::size_t p = 0; p < state.contacts.points.size(); ++p) state.contacts.points[p].gap = impacts.gaps_found[p];
    const CollideSettings& settings = state.search.settings;
    if (!settings.restitution.empty()) set_bounces(state.world, settings, state.contacts);
  }
  impacts.displaced.clear(), impacts.turned.clear(), impacts.attitude.clear(), impacts.gaps_found.clear(),
      impacts.impulses.clear();
  impacts.settled.clear(), impacts.starts.clear();
}

}  // namespace

void start_bounces(RankState& state, System& system) {
  const CollideSettings& settings = state.search.settings;
  forget_impacts(state);
  if (settings.restitution.empty()) {
    state.impacts.count = resolve_impacts(state, system);
    return;
  }
  const std::vector<SolverBody> predicted(system.bodies.begin(), system.bodies.end());
  std::vector<Vec3> left_out;
  for (std::size_t i = 0; i < state.world.size(); ++i) left_out.push_back(left_out_of_spin(system, i));
  state.impacts.count = resolve_impacts(state, system);
  set_starts(state, system, predicted, left_out);
  if (!state.impacts.settled.empty())
    renew_bounces(state.world, settings, state.impacts.starts, state.impacts.settled, state.contacts);
}

}  // namespace unibody
