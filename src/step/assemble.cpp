#include "step/assemble.hpp"

#include <algorithm>
#include <numeric>

#include "core/checked.hpp"
#include "partition/work.hpp"
#include "solve/centre_constraints.hpp"
#include "solve/colouring.hpp"
#include "solve/free_motion.hpp"
#include "step/adhesion.hpp"
#include "step/attach.hpp"
#include "step/bounces.hpp"
#include "step/edge_crossing.hpp"
#include "step/islands.hpp"
#include "step/prescribed.hpp"
#include "step/steadying.hpp"

namespace unibody {

BuildContext build_context(RankState& state, const System& system) {
  const Scene& scene = state.scene;
  BuildContext context{state.elements(), state.world, system, scene.solver, state.solver.sweeps_by_colour};
  context.time = state.time();
  context.contact_history = &state.history.contacts();
  context.least_creep = least_creep(state.traits);
  context.contacts = &state.contacts, context.contact_batch = &system.contacts();
  context.pairs = &scene.pairs;
  context.has_surfaces = state.has_surfaces();
  context.attached = state.ties.attached, context.has_attachments = state.traits.has_attachments;
  context.constraint_colours = state.rows.colours;
  context.memory = system.bodies.get_allocator().resource();
  context.exchange = [&state](std::span<std::int32_t> values) { state.exchange.refresh(values); };
  context.any_over_ranks = [&state](bool here) { return state.any_over_ranks(here); };
  return context;
}

namespace {

// predict() where nothing turns: homes and guests are particles, most of them alike.
void predict_particles(const RankState& state, System& system) {
  const BodyProperties* kind = nullptr;
  double inverse_mass = 0;
  Vec3 gain = Vec3::Zero();
  for (std::size_t i = 0; i < state.world.first_static(); ++i) {
    const BodyProperties& body = state.world.properties[i];
    if (body.is_dynamic() && (&body != kind || !state.drives.loaded.empty())) {
      kind = &body;
      inverse_mass = 1 / body.mass;
      const Vec3 force = state.drives.loaded.empty() ? body.force : properties_in_step(state, i).force;
      gain = state.step() * (state.drives.gravity + force / body.mass);
    }
    Eigen::Map<Vec3> v(system.bodies[i].v);
    v = state.world.velocity[i];
    if (!body.is_dynamic()) continue;  // pinned
    v += gain;
    system.bodies[i].inverse_mass = inverse_mass;
  }
}

// Manifold numbers colour by colour, and within a colour by length, so that the four lanes of a block have much the same length.
// A counting sort: stable, so that equal ones stay in key order.
void by_colour_and_length(const Contacts& contacts, const Colouring& colouring, std::span<std::uint32_t> order,
                          std::vector<std::uint32_t>& groups) {
  constexpr std::size_t lengths = 9;
  const std::size_t n = contacts.manifolds.size();
  const auto bucket = [&](std::size_t m) {
    return static_cast<std::size_t>(colouring.colour[m]) * lengths + (lengths - 1 - contacts.manifolds[m].count);
  };
  std::vector<std::uint32_t> begin(colouring.colours * lengths + 1, 0);
  for (std::size_t m = 0; m < n; ++m) ++begin[bucket(m) + 1];
  std::partial_sum(begin.begin(), begin.end(), begin.begin());
  groups.resize(colouring.colours);
  for (std::size_t c = 0; c < colouring.colours; ++c) groups[c] = begin[(c + 1) * lengths];
  for (std::size_t m = 0; m < n; ++m) order[begin[bucket(m)]++] = static_cast<std::uint32_t>(m);
}

// The order and the groups in which the contacts are laid out.
void order_contacts(RankState& state, std::span<std::uint32_t> order, std::vector<std::uint32_t>& groups) {
  std::iota(order.begin(), order.end(), 0);
  if (!state.solver.sweeps_by_colour) {
    groups = {static_cast<std::uint32_t>(order.size())};
  } else if (state.scene.solver.order == Order::sequential) {
    groups.resize(order.size());
    std::iota(groups.begin(), groups.end(), 1);
  } else {
    const Scratch::Frame frame(state.scratch);
    const Colouring colouring = colour_manifolds(state.world, state.contacts, state.exchange, &state.scratch);
    by_colour_and_length(state.contacts, colouring, order, groups);
    state.exchange.set_colours(batch_place<ContactBatch>, colouring.colour, colouring.colours);
  }
}

// How many constraints of all kinds share the mass of each body.
void count_constraints(const RankState& state, const BuildContext& context, System& system) {
  system.counts.assign(state.world.size() + 1, 0);
  std::span<std::int32_t> counts(system.counts);
  for_each_batch(system.batches, [&]<class B>(auto, B&) {
    if constexpr (!B::lasts) B::count(context, counts);
  });
  for (std::size_t i = 0; i < state.rows.lasting_counts.size(); ++i) counts[i] += state.rows.lasting_counts[i];
  state.exchange.refresh(counts);
}

// Among each body's constraints, for the Jacobi solvers.
void share_masses(RankState& state, System& system) {
  const Scratch::Frame frame(state.scratch);
  std::pmr::vector<double> sharers(state.world.size() + 1, 0.0, &state.scratch);
  if (state.scene.solver.mass_sharing == MassSharing::count) {
    std::copy(system.counts.begin(), system.counts.end(), sharers.begin());
  } else {
    find_sharers(system.batches, system, std::span(sharers).first(state.world.homes), &state.scratch);
    state.exchange.refresh(std::span(sharers));
  }
  for (std::size_t i = 0; i < state.world.first_static(); ++i) system.places[i][3] *= sharers[i];
}

void fill_places(RankState& state, System& system) {
  system.places.clear();
  if (!state.traits.has_centre_constraints) return;
  system.places.resize(state.world.size() + 1, Vec4d{});
  for (std::size_t i = 0; i < state.world.size(); ++i) {
    const Vec3& x = state.world.position[i];
    system.places[i] = Vec4d{x.x(), x.y(), x.z(), system.bodies[i].inverse_mass};
  }
  if (!system.counts.empty()) share_masses(state, system);
}

}  // namespace

void predict(const RankState& state, System& system) {
  const World& world = state.world;
  const std::size_t n = world.size();
  system.homes = world.homes, system.first_static = world.first_static();
  system.bodies.assign(n + 1, SolverBody{});
  system.isotropic.assign(n + 1, 1);
  system.rotates = world.has_rotations;
  system.step = state.step();
  system.stabilisation = state.scene.solver.level == Level::velocity ? state.scene.solver.stabilisation : -1;
  if (!world.has_rotations) predict_particles(state, system);
  for (std::size_t i = world.has_rotations ? 0 : world.first_static(); i < n; ++i) {
    const FreeMotion motion =
        state.drives.loaded.empty()
            ? predict_motion(world.properties[i], world.state(i), state.drives.gravity, state.step(), state.scene.planar)
            : predict_motion(properties_in_step(state, i), world.state(i), state.drives.gravity, state.step(),
                             state.scene.planar);
    system.bodies[i] = motion.body;
    const bool held_in_plane = state.scene.planar && state.traits.has_joints;  // whose rows would tilt a disc of scalar inertia
    system.isotropic[i] = motion.isotropic && !held_in_plane;
    if (system.isotropic[i]) continue;
    if (system.inertia.empty()) system.inertia.resize(n), system.gyroscopic.resize(n);
    system.inertia[i] = motion.isotropic ? InverseInertia{0, motion.body.inverse_inertia, 0, 0, 0, 0} : motion.inverse_inertia;
    system.gyroscopic[i] = motion.gyroscopic;
    system.bodies[i].inverse_inertia = 0;
  }
  if (state.drives.drag.any()) state.drives.drag.apply(world, state.time(), state.step(), world.homes, system.bodies);
  if (state.drives.pressure.any())  // after the drag, which must find the same velocities of guests
    state.drives.pressure.apply(world, state.time(), state.step(), world.homes, system.bodies);
  push_on_parts(state, system.bodies);
  if (state.traits.adheres) attract(state, system);
}

void assemble(RankState& state, System& system, std::span<double> geometric_stiffness) {
  state.ties.attached = attached_nodes(state.scene, state.world, state.time());
  if (state.scene.solver.level == Level::velocity)
    for (AttachedNode& a : state.ties.attached) a.gap *= state.scene.solver.stabilisation;
  BuildContext context = build_context(state, system);
  state.exchange.start_step(state.world, state.contacts);
  for_each_batch(system.batches, [&]<class B>(auto, B& batch) {
    if constexpr (!B::stencils_last) state.exchange.share(state.world, [&](const auto& f) { B::for_each_stencil(context, f); });
    batch.start_step();
  });
  state.exchange.finish_step();
  if (state.is_pushed() || state.traits.adheres) state.exchange.refresh(system.bodies);
  start_bounces(state, system);
  steady_by_stiffness(state, system, geometric_stiffness);

  std::pmr::vector<std::uint32_t> order(state.contacts.manifolds.size(), &state.scratch);
  std::vector<std::uint32_t> groups;
  if (!state.solver.sweeps_by_colour) count_constraints(state, context, system);
  order_contacts(state, order, groups);
  fill_places(state, system);
  context.displaced = state.impacts.displaced, context.bounce_starts = state.impacts.starts;
  context.contact_order = order, context.contact_groups = groups;
  bool by_wrenches = false;
  for_each_batch(system.batches, [&]<class B>(auto, B& batch) {
    if constexpr (!B::lasts) batch.build(context);
    by_wrenches = by_wrenches || (B::pushes_wrenches && batch.colours() > 0);
  });
  if (state.solver.sweeps_by_colour && by_wrenches) system.wrenches.assign(state.world.size() + 1, Wrench{});
  correct_crossings(state, system);
}

StepFacts facts_of(const RankState& state, System& system) {
  const Contacts& contacts = state.contacts;
  const bool may_bounce = !state.search.settings.restitution.empty();
  const auto bounces = [](const SurfaceContact& c) { return c.bounce > 0; };
  const bool tight = asks_for_tight_links(state.scene.solver, state.traits) &&
                     links_are_tight(geometric_stiffness(system.batches, system, state.history));
  const bool any_bounce = may_bounce && (std::ranges::any_of(contacts.bounce, [](double speed) { return speed > 0; }) ||
                                         std::ranges::any_of(contacts.surface, bounces));
  const bool any_contact = !contacts.manifolds.empty() || (state.has_surfaces() && !contacts.surface.empty());
  const bool counts = !state.scene.solver.iterations;  // else no plan asks for the work
  std::array<std::int64_t, 8> facts{
      any_contact, any_bounce, tight, 0, !contacts.surface.empty(), 0, 0, !state.rows.crossings.empty()};
  if (counts) facts[5] = facts[6] = counted_work_of(state.world, contacts);
  if (asks_for_islands(state.scene.solver, state.traits)) {
    const std::vector<std::int32_t> marks = constrained_islands(state, system);
    const auto [free, constrained] = system.contacts().set_islands(marks);
    facts[3] = free, facts[4] = facts[4] != 0 || constrained;
    if (counts) facts[6] = counted_work_of(state.world, contacts, marks);
  }
  check_mpi(MPI_Allreduce(MPI_IN_PLACE, facts.data(), static_cast<int>(facts.size()), MPI_INT64_T, MPI_SUM, state.comm()));
  if (facts[7] != 0) state.exchange.refresh(system.bodies);
  if (facts[3] == 0) system.contacts().forget_islands();
  StepFacts found{facts[0] != 0, facts[1] != 0, facts[2] != 0};
  found.error_ratio = state.history.error_ratio.ratio;
  found.free_contacts = facts[3] != 0, found.constrained_contacts = facts[4] != 0;
  found.work = facts[5] + state.traits.lasting_work, found.free_work = facts[6];
  return found;
}

namespace {

// A body that was hit within the step starts it where it seems to come from.
BodyState seeming_start(const RankState& state, std::size_t i) {
  BodyState start = state.world.state(i);
  if (state.impacts.displaced.empty() || i >= state.world.homes) return start;
  start.position += state.impacts.displaced[i];
  const Vec3& turn = state.impacts.attitude[i];
  if (!turn.isZero(0)) start.orientation = turn_by(turn) * start.orientation;
  return start;
}

}  // namespace

void finalise(RankState& state, const System& system) {
  World& world = state.world;
  std::vector<std::uint8_t> in_contact(world.size(), 0);
  for (const Manifold& m : state.contacts.manifolds)
    in_contact[static_cast<std::size_t>(m.slot_a)] = in_contact[static_cast<std::size_t>(m.slot_b)] = 1;
  for (std::size_t i = 0; i < world.homes && !world.has_rotations; ++i) {
    const SolverBody &solved = system.bodies[i], &moving = system.moving.empty() ? solved : system.moving[i];
    world.velocity[i] = Eigen::Map<const Vec3>(solved.v);
    world.position[i] += state.step() * Eigen::Map<const Vec3>(moving.v);
    if (!state.impacts.displaced.empty()) world.position[i] += state.impacts.displaced[i];
  }
  for (std::size_t i = world.has_rotations ? 0 : world.first_static(); i < world.size(); ++i) {
    if (i >= world.homes && i < world.first_static()) continue;
    if (world.properties[i].motion == Motion::fixed) continue;
    const Vec3 gyroscopic = system.isotropic[i] ? Vec3(Vec3::Zero()) : system.gyroscopic[i];
    const SolverBody &solved = system.bodies[i], &moving = system.moving.empty() ? solved : system.moving[i];
    world.set_state(
        i, finish_motion(world.properties[i], seeming_start(state, i), moving, solved, gyroscopic, state.step(),
                         state.scene.planar, (i >= world.first_static() || !in_contact[i]) && !state.is_tied(world.id[i])));
  }
}

}  // namespace unibody
