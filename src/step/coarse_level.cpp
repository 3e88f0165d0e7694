#include "step/coarse_level.hpp"

#include <algorithm>

#include "coarse/primal_dual.hpp"
#include "core/checked.hpp"
#include "step/rank_state.hpp"

namespace unibody {

namespace {

// The place of the run of bodies that has this one in the scene's list, -1: it is in none.
std::ptrdiff_t group_of(const std::vector<ConstraintGroup>& groups, Id id) {
  const auto next = std::ranges::upper_bound(groups, id, {}, &ConstraintGroup::first);
  if (next == groups.begin()) return -1;
  const auto group = next - 1;
  return id < group->first + group->count ? group - groups.begin() : -1;
}

// Of each run of bodies, whether any of them is in contact, attached to a dynamic body or jointed in this step. Collective.
std::vector<std::uint8_t> touched_groups(const RankState& state) {
  const auto& groups = state.scene.constraint_groups;
  std::vector<std::uint8_t> touched(groups.size(), 0);
  const auto touch = [&](Id id) {
    if (const std::ptrdiff_t g = group_of(groups, id); g >= 0) touched[static_cast<std::size_t>(g)] = 1;
  };
  for (const Manifold& m : state.contacts.manifolds) touch(m.id_a), touch(m.id_b);
  for (const SurfaceContact& c : state.contacts.surface)
    for (const Id id : c.ids) touch(id);
  for (const AttachedNode& a : state.attached)
    for (const Id id : a.ids) touch(id);
  for (const Joint& joint : state.scene.joints)
    for (const Id id : joint.ids) touch(id);
  check_mpi(MPI_Allreduce(MPI_IN_PLACE, touched.data(), static_cast<int>(touched.size()), MPI_UINT8_T, MPI_MAX, state.comm()));
  return touched;
}

// The more iterations a step may take, the more of them are Newton's.
int newton_iterations_of(const StepPlan& plan) {
  constexpr int sweeps_for_each = 25;
  return std::max(1, plan.iterations / sweeps_for_each);
}

}  // namespace

CoarseLevel::CoarseLevel(const Scene& scene) {
  if (!scene.solver.coarse) return;
  for (const ConstraintGroup& group : scene.constraint_groups) {
    std::vector<Vec3> points;
    for (Id k = 0; k < group.count; ++k) points.push_back(scene.body(group.first + k).state.position);
    aggregates.add(group.first, points);
  }
}

std::size_t CoarseLevel::bytes() const { return aggregates.bytes() + (solver ? solver->bytes() : 0); }

double solve_coarse_level(RankState& state, System& system, const StepPlan& plan, const std::vector<SolverBody>& predicted) {
  CoarseLevel& level = state.coarse;
  const std::vector<std::uint8_t> touched = touched_groups(state);
  if (std::ranges::find(touched, 0) == touched.end()) return 0;
  if (state.any_over_ranks(level.built_version != state.halo.version())) {
    level.solver = std::make_shared<PrimalDual>(state.world, state.constraints, level.aggregates, state.comm());
    level.built_version = state.halo.version();
  }
  PrimalDual& solver = *level.solver;
  std::vector<std::uint8_t> takes_part(state.world.size(), 0);
  for (std::size_t i = 0; i < state.world.first_static(); ++i)
    if (const std::ptrdiff_t g = group_of(state.scene.constraint_groups, state.world.id[i]); g >= 0)
      takes_part[i] = touched[static_cast<std::size_t>(g)] == 0;
  for_each_constraint_batch(
      system.batches, [&]<class C>(auto, const ConstraintBatch<C>& batch) { batch.get_multipliers(solver.multipliers<C>()); });
  PrimalDualSettings settings;
  settings.newton_iterations = newton_iterations_of(plan), settings.tolerance = plan.tolerance;
  const auto refresh = [&](std::span<Vec3> values) { state.exchange.refresh(values); };
  const PrimalDualReport report = solver.solve({predicted, takes_part, state.step(), refresh}, settings);
  for (std::size_t i = 0; i < state.world.first_static(); ++i)
    if (takes_part[i] != 0)
      for (int k = 0; k < 3; ++k) system.bodies[i].v[k] = solver.velocities()[i][k];
  for_each_constraint_batch(system.batches,
                            [&]<class C>(auto, ConstraintBatch<C>& batch) { batch.set_multipliers(solver.multipliers<C>()); });
  return report.residual;
}

}  // namespace unibody
