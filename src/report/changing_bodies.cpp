#include "report/changing_bodies.hpp"

#include "core/checked.hpp"

namespace unibody {

std::optional<ChangingBodies> changing_bodies(const Scene& scene) {
  if (!scene.bodies_come_and_go()) return {};
  Id first_node = scene.body_count();
  for (const ConstraintGroup& group : scene.constraint_groups) first_node = std::min(first_node, group.first);
  return ChangingBodies{[&scene](Id id) { return scene.body(id); }, first_node};
}

std::vector<NamedValue> past_columns(MPI_Comm comm, const Scene& scene, const World& world, const Past& past) {
  std::vector<NamedValue> columns;
  if (!scene.bodies_come_and_go()) return columns;
  auto bodies = static_cast<std::int64_t>(world.homes);
  check_mpi(MPI_Allreduce(MPI_IN_PLACE, &bodies, 1, MPI_INT64_T, MPI_SUM, comm));
  bodies += static_cast<std::int64_t>(world.size() - world.first_static());
  columns.push_back({"bodies (1)", static_cast<double>(bodies)});
  std::size_t inlet = 0;
  for (const BodyGroup& group : scene.groups) {
    if (!group.inlet) continue;
    const InletPast of = inlet < past.inlets.size() ? past.inlets[inlet] : InletPast{};
    ++inlet;
    const std::string name = "inlet_" + group.name;
    columns.push_back({name + "_placed (1)", static_cast<double>(of.placed)});
    columns.push_back({name + "_placed_mass (kg)", of.placed_mass});
    columns.push_back({name + "_waiting (1)", static_cast<double>(of.waiting.size())});
  }
  for (std::size_t o = 0; o < scene.outlets.size(); ++o) {
    const OutletPast of = o < past.outlets.size() ? past.outlets[o] : OutletPast{};
    const std::string name = "outlet_" + scene.outlets[o].name;
    columns.push_back({name + "_removed (1)", static_cast<double>(of.removed)});
    columns.push_back({name + "_removed_mass (kg)", of.removed_mass});
  }
  return columns;
}

}  // namespace unibody
