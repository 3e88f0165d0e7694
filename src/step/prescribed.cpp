#include "step/prescribed.hpp"

#include "solve/free_motion.hpp"

namespace unibody {

void set_prescribed_velocities(RankState& state) {
  World& world = state.world;
  const double from = state.time(), to = from + state.step();
  for (const BodyGroup* group : state.prescribed) {
    const Vec3 velocity = group->motion->mean_velocity(from, to), spin = group->motion->angular_velocity.mean(from, to);
    for (Id k = 0; k < group->count; ++k) {
      const auto slot = static_cast<std::size_t>(world.find(group->first + k));  // statics are on every rank
      world.velocity[slot] = velocity;
      if (!world.has_rotations) continue;
      world.angular_velocity[slot] = spin_of_turn(spin, state.step(), !state.is_tied(group->first + k));
    }
  }
}

}  // namespace unibody
