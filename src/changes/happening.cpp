#include "changes/happening.hpp"

#include <algorithm>
#include <numeric>

#include "core/checked.hpp"

namespace unibody {

namespace {

using Action = Event::Action;

// The bodies of a group that are absent now, as they were at the start: of statics all, of others this rank's share.
void add_absent(const Simulation& simulation, const BodyGroup& group, Simulation::BodyChanges& changes) {
  const World& world = simulation.world;
  const Id ranks = simulation.halo.size(), rank = simulation.halo.rank();
  std::vector<std::uint8_t> present(static_cast<std::size_t>(group.count));
  for (Id k = 0; k < group.count; ++k) {
    const Slot slot = world.find(group.first + k);
    present[static_cast<std::size_t>(k)] = slot >= 0 && (world.is_home(slot) || world.is_static(slot)) ? 1 : 0;
  }
  check_mpi(
      MPI_Allreduce(MPI_IN_PLACE, present.data(), static_cast<int>(present.size()), MPI_UINT8_T, MPI_MAX, simulation.comm()));
  const Id first = group.is_static ? 0 : group.count * rank / ranks,
           last = group.is_static ? group.count : group.count * (rank + 1) / ranks;
  for (Id k = first; k < last; ++k)
    if (present[static_cast<std::size_t>(k)] == 0) (group.is_static ? changes.statics : changes.homes).push_back(group.make(k));
}

// This rank's bodies of the group, held or not from now on. They leave and come again, since guests must learn it.
void hold(const World& world, const BodyGroup& group, bool held, Simulation::BodyChanges& changes) {
  for (std::size_t i = 0; i < world.homes; ++i) {
    if (world.id[i] < group.first || world.id[i] >= group.first + group.count) continue;
    Body body = world.body(i);
    body.properties.motion = held ? Motion::pinned : Motion::dynamic;
    body.state.velocity.setZero(), body.state.angular_velocity.setZero();
    changes.removed.push_back(body.id), changes.homes.push_back(body);
  }
}

void change_bodies(Simulation& simulation, const Event& event) {
  Simulation::BodyChanges changes;
  for (const std::size_t g : event.groups) {
    const BodyGroup& group = simulation.scene.groups[g];
    if (event.action == Action::add) {
      add_absent(simulation, group, changes);
    } else if (event.action == Action::remove) {
      const std::size_t before = changes.removed.size();
      changes.removed.resize(before + static_cast<std::size_t>(group.count));
      std::iota(changes.removed.begin() + static_cast<std::ptrdiff_t>(before), changes.removed.end(), group.first);
    } else {
      hold(simulation.world, group, event.action == Action::fix, changes);
    }
  }
  simulation.change_bodies(changes);
}

// What an event does to the scene itself. start: s, when it happens.
void change_laws(Scene& scene, const Event& event, double start) {
  if (event.action == Action::motor)
    for (const std::size_t joint : event.joints) scene.joints[joint].target = event.value.later(start);
  if (event.action == Action::friction)
    scene.friction_in_time->set(event.materials[0], event.materials[1], event.value.later(start));
}

double start_of(const Scene& scene, std::int64_t frame) { return static_cast<double>(frame - 1) * scene.time.frame; }

}  // namespace

void repeat_past(Scene& scene, const History& history) {
  std::vector<std::size_t> order(scene.events.size());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::stable_sort(order, {}, [&](std::size_t e) { return history.past.events[e]; });
  for (const std::size_t e : order)
    if (const std::int64_t frame = history.past.events[e]; frame > 0) change_laws(scene, scene.events[e], start_of(scene, frame));
}

Changed happen(Simulation& simulation, Scene& scene, std::int64_t frame) {
  const double now = start_of(scene, frame), rounding = 1e-9 * scene.time.frame;
  Changed changed = Changed::nothing;
  for (std::size_t e = 0; e < scene.events.size(); ++e) {
    const Event& event = scene.events[e];
    std::int64_t& happened = simulation.history.past.events[e];
    if (happened == 0 && !event.when && event.time <= now + rounding) happened = frame;
    if (happened != frame) continue;
    change_laws(scene, event, now);
    if (event.action == Action::release) simulation.release(event.joints);
    if (event.groups.empty()) continue;
    change_bodies(simulation, event);
    changed = event.action == Action::add ? Changed::much : std::max(changed, Changed::little);
  }
  return changed;
}

}  // namespace unibody
