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
  for (const AttachedNode& a : state.ties.attached)
    for (const Id id : a.ids) touch(id);
  for (std::size_t j = 0; j < state.scene.joints.size(); ++j)
    if (!state.ties.joint_input.is_broken(static_cast<std::int64_t>(j)))
      for (const Id id : state.scene.joints[j].ids) touch(id);
  check_mpi(MPI_Allreduce(MPI_IN_PLACE, touched.data(), static_cast<int>(touched.size()), MPI_UINT8_T, MPI_MAX, state.comm()));
  return touched;
}

// The more iterations a step may take, the more of them are Newton's.
int newton_iterations_of(const StepPlan& plan) {
  constexpr int sweeps_for_each = 25;
  return std::max(2, plan.iterations / sweeps_for_each);
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

namespace {

// The part that each slot is of, -1: of none, as they are given for runs of bodies.
std::vector<std::int32_t> parts_of_slots(const RankState& state, std::span<const std::uint8_t> left_out) {
  std::vector<std::int32_t> part(state.world.size(), -1);
  for (std::size_t i = 0; i < state.world.first_static(); ++i)
    if (const std::ptrdiff_t g = group_of(state.scene.constraint_groups, state.world.id[i]);
        g >= 0 && left_out[static_cast<std::size_t>(g)] == 0)
      part[i] = static_cast<std::int32_t>(g);
  return part;
}

template <class C>
bool is_taken(const RankState& state, const Constraint<C>& c) {
  return std::ranges::any_of(c.ids, [&](Id id) {
    const Slot slot = state.world.find(id);
    return slot >= 0 && state.coarse.taken[static_cast<std::size_t>(slot)] >= 0;
  });
}

// Takes over the velocities and multipliers of the parts that gain no energy.
CoarseSolve take_over(RankState& state, System& system, const PrimalDualReport& report, std::vector<std::int32_t> part) {
  CoarseLevel& level = state.coarse;
  PrimalDual& solver = *level.solver;
  CoarseSolve done;
  for (const PartReport& k : report.parts)
    if (k.gains_energy())
      ++done.counts.gaining;
    else
      done.off = std::max(done.off, k.momentum);
  for (std::int32_t& k : part)
    if (k >= 0 && report.parts[static_cast<std::size_t>(k)].gains_energy()) k = -1;
  level.taken = std::move(part);
  for (std::size_t i = 0; i < state.world.first_static(); ++i)
    if (level.taken[i] >= 0)
      for (int k = 0; k < 3; ++k) system.bodies[i].v[k] = solver.velocities()[i][k];
  for_each_constraint_batch(system.batches, [&]<class C>(auto type, ConstraintBatch<C>& batch) {
    const auto& list = std::get<decltype(type)::value>(state.ties.constraints);
    std::vector<std::array<double, C::rows>> all(list.size());
    batch.get_multipliers(all);
    for (std::size_t i = 0; i < list.size(); ++i)
      if (is_taken(state, list[i])) all[i] = solver.multipliers<C>()[i];
    batch.set_multipliers(all);
  });
  return done;
}

}  // namespace

CoarseSolve solve_coarse_level(RankState& state, System& system, const StepPlan& plan, const std::vector<SolverBody>& predicted) {
  CoarseLevel& level = state.coarse;
  level.taken.clear();
  const std::vector<std::uint8_t> touched = touched_groups(state);
  const std::int64_t touching = std::ranges::count_if(touched, [](std::uint8_t t) { return t != 0; });
  if (std::ranges::find(touched, 0) == touched.end()) return {0, {0, touching, 0}};
  if (state.any_over_ranks(level.built_version != state.halo.version())) {
    level.solver = std::make_shared<PrimalDual>(state.world, state.ties.constraints, level.aggregates, state.comm());
    level.built_version = state.halo.version();
  }
  PrimalDual& solver = *level.solver;
  std::vector<std::int32_t> part = parts_of_slots(state, touched);
  for_each_constraint_batch(system.batches, [&]<class C>(auto, const ConstraintBatch<C>&) {
    for (auto& lambda : solver.multipliers<C>()) lambda.fill(0);
  });
  PrimalDualSettings settings;
  settings.newton_iterations = newton_iterations_of(plan), settings.tolerance = plan.tolerance;
  const auto refresh = [&](std::span<Vec3> values) { state.exchange.refresh(values); };
  const PrimalDualReport report = solver.solve({predicted, part, touched.size(), state.step(), refresh}, settings);
  CoarseSolve done = take_over(state, system, report, std::move(part));
  done.counts.touching = touching;
  done.counts.solved = static_cast<std::int64_t>(touched.size()) - touching - done.counts.gaining;
  return done;
}

void forget_multipliers(RankState& state) {
  if (state.coarse.taken.empty()) return;
  for_each_type(state.ties.constraints, [&]<class C>(auto, const ConstraintList<C>& list) {
    auto& remembered = state.history.of<ConstraintBatch<C>>();
    for (std::size_t i = 0; i < list.size(); ++i)
      if (is_taken(state, list[i])) remembered[i].fill(0);
  });
}

}  // namespace unibody
