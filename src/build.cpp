#include "build.hpp"

#include <algorithm>

#include "constraints/constraint_types.hpp"

namespace unibody {

World build_world(MPI_Comm comm, const Scene& scene) {
  int rank = 0, size = 1;
  MPI_Comm_rank(comm, &rank);
  MPI_Comm_size(comm, &size);
  const Id count = scene.body_count();
  const Id begin = count * rank / size, end = count * (rank + 1) / size;

  std::vector<Body> homes, statics;
  for (const BodyGroup& group : scene.groups) {
    const Id first = group.is_static ? 0 : std::max<Id>(0, begin - group.first);
    const Id last = group.is_static ? group.count : std::min(group.count, end - group.first);
    for (Id k = first; k < last; ++k) {
      Body body = group.make(k);
      body.id = group.first + k;
      (group.is_static ? statics : homes).push_back(body);
    }
  }
  return make_world(homes, statics, scene.has_rotations());
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

void hold_pinned(const Scene& scene, World& world, double time) {
  for (const Pin& pin : scene.pins) {
    const Slot slot = world.find(pin.id);
    if (slot < 0) continue;
    const auto i = static_cast<std::size_t>(slot);
    const Motion motion = time < pin.release ? Motion::pinned : Motion::dynamic;
    if (motion == Motion::pinned) world.velocity[i] = Vec3::Zero();
    if (world.properties[i].motion == motion) continue;
    BodyProperties properties = world.properties[i];
    properties.motion = motion;
    world.properties.set(i, properties);
  }
}

World make_world(const std::vector<Body>& homes, const std::vector<Body>& statics, bool has_rotations) {
  World world;
  world.has_rotations = has_rotations;
  world.homes = homes.size();
  world.resize(homes.size() + statics.size());
  for (std::size_t i = 0; i < homes.size(); ++i) world.set(i, homes[i]);
  for (std::size_t i = 0; i < statics.size(); ++i) world.set(homes.size() + i, statics[i]);
  return world;
}

}  // namespace unibody
