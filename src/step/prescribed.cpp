#include "step/prescribed.hpp"

#include <algorithm>

namespace unibody {

void set_prescribed_velocities(RankState& state) {
  World& world = state.world;
  const double from = state.time(), to = from + state.step();
  for (const BodyGroup* group : state.drives.prescribed) {
    const Vec3 velocity = group->motion->mean_velocity(from, to), spin = group->motion->angular_velocity.mean(from, to);
    for (Id k = 0; k < group->count; ++k) {
      const Slot found = world.find(group->first + k);  // statics are on every rank
      if (found < 0) continue;                          // absent
      const auto slot = static_cast<std::size_t>(found);
      world.velocity[slot] = velocity;
      if (!world.has_rotations) continue;
      world.angular_velocity[slot] = spin;
    }
  }
}

void set_loads(RankState& state) {
  const double from = state.time(), to = from + state.step();
  if (state.scene.gravity_in_time)
    state.drives.gravity = state.search.settings.gravity = state.scene.gravity_in_time->mean(from, to);
  if (state.scene.friction_in_time) state.search.settings.friction = state.scene.friction_in_time->mean(from, to);
  state.world.friction_axes = state.search.friction_axes;
  state.world.surface_motions.clear();
  for (const BodyGroup* group : state.drives.belts)
    state.world.surface_motions.push_back({group->first, group->count, group->surface_motion->velocity.mean(from, to),
                                           group->surface_motion->angular_velocity.mean(from, to)});
}

BodyProperties properties_in_step(const RankState& state, std::size_t slot) {
  BodyProperties body = state.world.properties[slot];
  const Id id = state.world.id[slot];
  const auto has = [id](const BodyGroup* group) { return id >= group->first && id < group->first + group->count; };
  const auto group = std::ranges::find_if(state.drives.loaded, has);
  if (group == state.drives.loaded.end()) return body;
  const double from = state.time(), to = from + state.step();
  body.force = (*group)->load->force.mean(from, to), body.torque = (*group)->load->torque.mean(from, to);
  return body;
}

void push_on_parts(const RankState& state, std::span<SolverBody> bodies) {
  const double from = state.time(), to = from + state.step();
  for (const PartLoad& load : state.scene.part_loads) {
    const Vec3 impulse = state.step() * load.force.mean(from, to);
    for (const auto& [node, share] : load.shares) {
      const Slot slot = state.world.find(node);
      if (slot < 0 || !state.world.is_home(slot)) continue;
      SolverBody& body = bodies[static_cast<std::size_t>(slot)];
      Eigen::Map<Vec3>(body.v) += body.inverse_mass * share * impulse;
    }
  }
}

}  // namespace unibody
