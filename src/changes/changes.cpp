#include "changes/changes.hpp"

#include "changes/happening.hpp"
#include "changes/inlets.hpp"
#include "changes/outlets.hpp"

namespace unibody {

void start_past(const Scene& scene, History& history) {
  history.past = {};
  history.past.events.assign(scene.events.size(), 0);
  for (const BodyGroup& group : scene.groups)
    if (group.inlet) history.past.inlets.emplace_back();
  history.past.outlets.resize(scene.outlets.size());
}

Changed change_scene(Simulation& simulation, Scene& scene, std::int64_t frame) {
  Changed changed = happen(simulation, scene, frame);
  if (!scene.outlets.empty() && let_out(simulation)) changed = std::max(changed, Changed::little);
  if (!simulation.history.past.inlets.empty() && let_in(simulation, frame)) changed = std::max(changed, Changed::little);
  return changed;
}

}  // namespace unibody
