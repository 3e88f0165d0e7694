#include "step/detect.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

#include "collide/contact_faults.hpp"
#include "collide/crowds.hpp"
#include "collide/friction_frames.hpp"
#include "collide/stiction.hpp"
#include "core/assume.hpp"
#include "core/checked.hpp"
#include "core/errors.hpp"
#include "core/largest.hpp"
#include "joints/coupling_set.hpp"
#include "partition/work.hpp"
#include "scene/stiffness.hpp"
#include "step/adhesion.hpp"
#include "step/assemble.hpp"
#include "step/attach.hpp"
#include "step/build.hpp"
#include "step/liquid.hpp"
#include "world/world_faults.hpp"

namespace unibody {

void make_constraints(RankState& state) {
  state.ties.constraints = build_constraints(state.scene, state.world);
  state.ties.joints = joints_here(state.scene.joints, state.world);
  state.ties.couplings = couplings_here(state.scene.couplings, state.world);
  state.ties.attachments = attachments_here(state.world, state.scene.attachments);
  for_each_batch_type([&]<class B>(auto, std::type_identity<B>) {
    if constexpr (KeyedBatch<B>) {
      std::size_t count = 0;
      B::for_each_element(state.elements(), [&](const typename B::Key&, std::span<const Id>) { ++count; });
      state.history.of<B>().assign(count, {});
    }
  });
  std::vector<Id> wanted = partners(state.world, state.ties.constraints);
  const auto add = [&](const std::vector<Id>& more) {
    std::vector<Id> both;
    std::set_union(wanted.begin(), wanted.end(), more.begin(), more.end(), std::back_inserter(both));
    wanted = std::move(both);
  };
  if (state.needs_surfaces()) add(state.search.surfaces.partners(state.world));
  if (state.traits.has_attachments) add(partners(state.world, state.scene.attachments));
  if (state.traits.has_joints) add(partners(state.scene.joints, state.ties.joints, state.world));
  add(partners(state.scene.couplings, state.ties.couplings, state.world));
  state.halo.reset(state.world, wanted);
  state.rows.colours = {};
  for_each_type(state.ties.constraints, [&](auto type, const auto& list) {
    for (const auto& c : list) state.rows.colours[type.value] = std::max(state.rows.colours[type.value], c.colour + 1);
  });
  check_mpi(MPI_Allreduce(MPI_IN_PLACE, state.rows.colours.data(), static_cast<int>(state.rows.colours.size()), MPI_INT32_T,
                          MPI_MAX, state.comm()));
  SceneTraits& traits = state.traits;
  traits.has_centre_constraints = std::ranges::any_of(state.rows.colours, [](std::int32_t n) { return n > 0; });
  traits.only_links = true, traits.has_solids = false, traits.only_solids = traits.has_centre_constraints;
  for_each_type(state.ties.constraints, [&]<class C>(auto type, const ConstraintList<C>&) {
    if (state.rows.colours[type.value] == 0) return;
    traits.only_links = traits.only_links && is_link<C>;
    traits.has_solids = traits.has_solids || fills_space<C>;
    traits.only_solids = traits.only_solids && fills_space<C>;
  });
  if (asks_for_stiffness(state.scene.solver, traits) && std::isinf(traits.stiffness)) {  // of the start, however late it is
    const double here = stiffness_number(state.scene, state.ties.constraints, stiffest_for_total);
    traits.stiffness = largest_of_ranks(state.comm(), here);
  }
  traits.lasting_work = counted_work_of(state.world, state.ties.constraints);
  check_mpi(MPI_Allreduce(MPI_IN_PLACE, &traits.lasting_work, 1, MPI_INT64_T, MPI_SUM, state.comm()));
  for (const Joint& joint : state.scene.joints) traits.lasting_work += static_cast<std::int64_t>(cost_of(joint));
}

void refresh_guests(RankState& state) {
  const PhaseClock::Scope scope(state.clock, Phase::halo);
  hold_pinned(state.scene, state.world, state.time(), state.step());  // homes, so that their guests learn it
  state.search.settings.has_past = state.when.steps_done > 0;
  if (state.is_alone() && !state.needs_surfaces())
    state.halo.refresh_partners(state.world);
  else
    state.halo.refresh_guests(state.world, state.search.settings, state.needs_surfaces() ? &state.search.surfaces : nullptr);
  hold_pinned(state.scene, state.world, state.time(), state.step());  // guests: a refresh brings states only
  assume([&] { return fault_of(state.world); });
}

void build_lasting(RankState& state, System& system) {
  if (state.traits.has_joints)
    state.ties.joint_slots =
        joint_slots(state.scene.joints, state.ties.joints, state.world, static_cast<Slot>(state.world.size()));
  state.ties.coupling_slots =
      coupling_slots(state.scene.couplings, state.ties.couplings, state.world, static_cast<Slot>(state.world.size()));
  const BuildContext context = build_context(state, system);
  state.exchange.start_lasting();
  state.rows.lasting_counts.clear();
  if (!state.solver.sweeps_by_colour && state.traits.has_centre_constraints)
    state.rows.lasting_counts.assign(state.world.size() + 1, 0);
  for_each_batch(system.batches, [&]<class B>(auto place, B& batch) {
    if constexpr (B::lasts) {
      batch.build(context);
      if (!state.rows.lasting_counts.empty()) B::count(context, state.rows.lasting_counts);
    }
    if constexpr (B::stencils_last)
      state.exchange.share_lasting(state.world, place, state.solver.sweeps_by_colour,
                                   [&](const auto& f) { B::for_each_stencil(context, f); });
  });
  if (state.drives.drag.any()) state.drives.drag.build(state.world, state.search.surfaces);
  if (state.drives.pressure.any()) state.drives.pressure.build(state.world, state.search.surfaces);
}

namespace {

// The nearest image of a body is the only one that it may touch another in as long as neither reaches over more than half of the
// period. Stops the run where one does, which would miss contacts. Collective.
void check_reach(const RankState& state) {
  const World& world = state.world;
  constexpr Id none = std::numeric_limits<Id>::max();
  Id first = none;
  for (std::size_t i = 0; i < world.size(); ++i) {
    if (world.properties[i].shape.kind == ShapeKind::plane) continue;
    const Bounds bounds = swept_bounds(world, i, state.search.settings);
    for (int k = 0; k < 3; ++k)
      if (world.period.along(k) && !(bounds.upper[k] - bounds.lower[k] <= 0.5 * world.period.length[k]))
        first = std::min(first, world.id[i]);
  }
  check_mpi(MPI_Allreduce(MPI_IN_PLACE, &first, 1, MPI_INT64_T, MPI_MIN, state.comm()));
  if (first == none) return;
  throw RunError(state.scene.body_name(first) +
                 ": with what it may travel in a step it reaches over more than half of the period, where contacts could be "
                 "missed: the scene needs more time.substeps or a longer period");
}

}  // namespace

bool find_contacts(RankState& state) {
  if (state.is_alone()) return false;
  if (state.world.period.any()) check_reach(state);
  state.search.crowd_ranks = crowd_ranks(state.world);
  const bool crowded = state.any_over_ranks(!state.search.crowd_ranks.empty());
  if (crowded) {
    state.search.crowd_ranks.resize(state.world.size(), -1);
    state.halo.tell_guests(state.world, state.search.crowd_ranks);
  }
  state.impacts.gaps_found.clear();
  const Scratch::Frame frame(state.scratch);
  Collider(&state.scratch)
      .collide(state.world, state.search.settings, state.contacts,
               state.search.surfaces.empty() ? nullptr : &state.search.surfaces, state.search.crowd_ranks);
  leave_out_attached(state.scene, state.world, state.time(), state.contacts);
  leave_out_jointed(state.ties.joint_input, state.contacts);
  if (!state.search.settings.stiction.empty()) add_stiction(state.world, state.search.settings, state.contacts);
  if (!state.world.friction_axes.empty()) add_friction_frames(state.world, state.contacts);
  renew_bridges(state);
  state.rows.adhesive = adhesive_impulses(state);
  assume([&] { return fault_of(state.contacts, state.world); });
  return crowded;
}

CrowdCount count_crowds(const RankState& state) {
  CrowdCount count;
  const std::span ranks(state.search.crowd_ranks.data(), std::min(state.search.crowd_ranks.size(), state.world.homes));
  for (const std::int32_t rank : ranks) count.bodies += rank >= 0, count.most = std::max<std::int64_t>(count.most, rank + 1);
  check_mpi(MPI_Allreduce(MPI_IN_PLACE, &count.bodies, 1, MPI_INT64_T, MPI_SUM, state.comm()));
  check_mpi(MPI_Allreduce(MPI_IN_PLACE, &count.most, 1, MPI_INT64_T, MPI_MAX, state.comm()));
  for (std::size_t i = 0; i < ranks.size(); ++i)
    if (ranks[i] + 1 == count.most && (count.one < 0 || state.world.id[i] < count.one)) count.one = state.world.id[i];
  constexpr Id none = std::numeric_limits<Id>::max();
  if (count.one < 0) count.one = none;
  check_mpi(MPI_Allreduce(MPI_IN_PLACE, &count.one, 1, MPI_INT64_T, MPI_MIN, state.comm()));
  return count;
}

}  // namespace unibody
