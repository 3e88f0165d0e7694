#include "changes/outlets.hpp"

#include <algorithm>

#include "core/checked.hpp"
#include "core/exact_sum.hpp"

namespace unibody {

namespace {

bool leaves_by(const Outlet& outlet, const World& world, std::size_t slot) {
  const BodyProperties& body = world.properties[slot];
  const Vec3 place = world.period.wrapped(world.position[slot], outlet.low);
  return body.is_dynamic() && world.id[slot] >= outlet.bodies.first && world.id[slot] < outlet.bodies.end &&
         (outlet.bodies.material < 0 || body.material == outlet.bodies.material) && (place.array() >= outlet.low.array()).all() &&
         (place.array() < outlet.high.array()).all();
}

}  // namespace

bool let_out(Simulation& simulation) {
  const World& world = simulation.world;
  const std::vector<Outlet>& outlets = simulation.scene.outlets;
  std::vector<ExactSum> sums(2 * outlets.size());  // number and mass
  Simulation::BodyChanges changes;
  for (std::size_t i = 0; i < world.homes; ++i) {
    const auto outlet = std::ranges::find_if(outlets, [&](const Outlet& o) { return leaves_by(o, world, i); });
    if (outlet == outlets.end() || simulation.is_tied(world.id[i])) continue;
    changes.removed.push_back(world.id[i]);
    const auto o = static_cast<std::size_t>(outlet - outlets.begin());
    sums[2 * o] += 1, sums[2 * o + 1] += world.properties[i].mass;
  }
  const std::vector<double> all = all_sums(simulation.comm(), sums);
  bool any = false;
  for (std::size_t o = 0; o < outlets.size(); ++o) {
    OutletPast& past = simulation.history.past.outlets[o];
    past.removed += static_cast<Id>(all[2 * o]), past.removed_mass += all[2 * o + 1];
    any = any || all[2 * o] > 0;
  }
  if (any) simulation.change_bodies(changes);
  return any;
}

}  // namespace unibody
