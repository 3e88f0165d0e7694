#include "step/build.hpp"

#include <algorithm>

#include "constraints/constraint_types.hpp"
#include "core/checked.hpp"
#include "solve/free_motion.hpp"

namespace unibody {

World build_world(MPI_Comm comm, const Scene& scene) {
  int rank = 0, size = 1;
  check_mpi(MPI_Comm_rank(comm, &rank));
  check_mpi(MPI_Comm_size(comm, &size));
  const Id count = scene.body_count();
  const Id begin = count * rank / size, end = count * (rank + 1) / size;

  std::vector<Body> homes, statics;
  for (const BodyGroup& group : scene.groups) {
    if (group.start == Start::absent) continue;
    const Id first = group.is_static ? 0 : std::max<Id>(0, begin - group.first);
    const Id last = group.is_static ? group.count : std::min(group.count, end - group.first);
    for (Id k = first; k < last; ++k) {
      Body body = group.make(k);
      body.id = group.first + k;
      (group.is_static ? statics : homes).push_back(body);
    }
  }
  return make_world(homes, statics, scene.has_rotations(), scene.period);
}

ConstraintSet build_constraints(const Scene& scene, const World& world) {
  const auto end = world.id.begin() + static_cast<std::ptrdiff_t>(world.homes);
  const auto is_home = [&](Id id) { return std::binary_search(world.id.begin(), end, id); };
  ConstraintSet result;
  for (const ConstraintGroup& group : scene.constraint_groups) {
    auto node = std::lower_bound(world.id.begin(), end, group.first);
    for (; node != end && *node < group.first + group.count; ++node) {
      ConstraintSet touching;
      group.touching(*node, touching);
      for_each_type(touching, [&](auto type, const auto& list) {
        for (const auto& c : list)  // once: with the first of its home bodies
          if (std::none_of(c.ids.begin(), c.ids.end(), [&](Id id) { return id < *node && is_home(id); }))
            std::get<type.value>(result).push_back(c);
      });
    }
  }
  for_each_type(result, [](auto, auto& list) { std::sort(list.begin(), list.end()); });
  return result;
}

std::vector<Id> partners(const World& world, const ConstraintSet& constraints) {
  std::vector<Id> wanted;
  for_each_type(constraints, [&](auto, const auto& list) {
    for (const auto& c : list)
      for (const Id id : c.ids)
        if (world.find(id) < 0) wanted.push_back(id);
  });
  std::sort(wanted.begin(), wanted.end());
  wanted.erase(std::unique(wanted.begin(), wanted.end()), wanted.end());
  return wanted;
}

namespace {

// m/s, at which a held body moves in the step. It aims at the place after the step, so that no error adds up.
Vec3 velocity_of_held(const Scene& scene, const World& world, const Pin& pin, const Vec3& present, double step) {
  const Slot slot = pin.body < 0 ? -1 : world.find(pin.body);
  if (slot < 0) return Vec3::Zero();
  const auto i = static_cast<std::size_t>(slot);
  const BodyProperties& holder = world.properties[i];
  if (holder.motion == Motion::fixed) return Vec3::Zero();
  const FreeMotion motion = predict_motion(holder, world.state(i), scene.gravity, step, scene.planar);
  const BodyState next = finish_motion(holder, world.state(i), motion.body, motion.gyroscopic, step, scene.planar);
  return (next.position + next.orientation * pin.place - present) / step;
}

}  // namespace

void hold_pinned(const Scene& scene, World& world, double time, double step) {
  for (const Pin& pin : scene.pins) {
    const Slot slot = world.find(pin.id);
    if (slot < 0) continue;
    const auto i = static_cast<std::size_t>(slot);
    const Motion motion = time < pin.release ? Motion::pinned : Motion::dynamic;
    if (motion == Motion::pinned) world.velocity[i] = velocity_of_held(scene, world, pin, world.position[i], step);
    if (world.properties[i].motion == motion) continue;
    BodyProperties properties = world.properties[i];
    properties.motion = motion;
    world.properties.set(i, properties);
  }
}

}  // namespace unibody
