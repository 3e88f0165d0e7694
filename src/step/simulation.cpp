#include "step/simulation.hpp"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "core/largest.hpp"
#include "partition/migrate.hpp"
#include "solve/centre_constraints.hpp"
#include "step/assemble.hpp"
#include "step/breaking.hpp"
#include "step/build.hpp"
#include "step/division.hpp"
#include "step/move_history.hpp"
#include "step/newton_step.hpp"
#include "step/prescribed.hpp"
#include "step/pressed_areas.hpp"
#include "step/side_guard.hpp"
#include "step/stages.hpp"
#include "step/steadying.hpp"
#include "step/struck.hpp"

namespace unibody {

Simulation::Simulation(MPI_Comm over, const Scene& of, PhaseClock& timed_by, bool in_shared_memory)
    : RankState(over, of, timed_by, in_shared_memory) {}

namespace {

// m, of this rank's share of the moving bodies that are there at any time.
double smallest_of_all(const Scene& scene, int rank, int ranks) {
  double smallest = std::numeric_limits<double>::infinity();
  for (const BodyGroup& group : scene.groups) {
    if (group.is_static) continue;
    for (Id k = group.count * rank / ranks; k < group.count * (rank + 1) / ranks; ++k)
      smallest = std::min(smallest, smallest_size(group.make(k).properties.shape));
  }
  return smallest;
}

}  // namespace

void Simulation::resolve_automatic_settings() {
  double& smallest = traits.smallest_size;
  smallest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < world.homes; ++i) smallest = std::min(smallest, smallest_size(world.properties[i].shape));
  if (scene.bodies_come_and_go()) smallest = smallest_of_all(scene, halo.rank(), halo.size());
  smallest = smallest_of_ranks(comm(), smallest);
  search.settings.margin = plan(scene.solver, traits).margin;
}

void Simulation::make_constraints() {
  unibody::make_constraints(*this);
  done_.constraints_made = true, done_.built_version = -1;
}

void Simulation::detect() {
  if (done_.contacts_found) return;
  if (!done_.constraints_made) make_constraints();
  set_prescribed_velocities(*this);
  set_loads(*this);
  refresh_guests(*this);
  if (done_.built_version != halo.version()) build_lasting(*this, system_);
  done_.built_version = halo.version();
  measure_pressed_areas(*this);
  if (!std::exchange(done_.loads_compared, true)) break_overloaded(*this);
  know_breaks(*this);
  const PhaseClock::Scope scope(clock, Phase::collide);
  done_.is_crowded = find_contacts(*this);
  done_.contacts_found = true;
}

StepReport Simulation::step(const StepRequest& request) {
  detect();
  renew_fineness(*this);
  const int parts = parts_of_step(*this);
  if (parts == 1) {
    const StepReport report = take_part(request);
    ++when.steps_done;
    return report;
  }
  StepReport all;
  StepRequest within;  // of a part before the last
  within.name_above = request.name_above, within.impulses = request.impulses;
  set_length(when.whole_step / parts);
  for (int k = 0; k < parts; ++k) {
    when.in_step = k * RankState::step();
    const StepReport report = take_part(k + 1 == parts ? request : within);
    all.add_part(report, k == 0);
  }
  set_length(when.whole_step);
  when.in_step = 0, ++when.steps_done;
  return all;
}

// Batches that last know the length, and so do contacts.
void Simulation::set_length(double length) {
  set_step_length(*this, length);
  done_.contacts_found = false, done_.built_version = -1;
}

StepReport Simulation::take_part(const StepRequest& request) {
  StepReport report;
  for (int tries = 0;; ++tries) {
    detect();
    const PhaseClock::Scope scope(clock, Phase::solve);
    const Scratch::Frame frame(scratch);
    if (traits.has_joints) rows.geometric_stiffness = geometric_stiffness_of_joints(*this);
    StepRequest asked = request;
    asked.may_be_outrun = tries < most_searches;
    report = take_in_form(asked);
    if (!report.outrun) {
      const SideGuard guard(*this);
      finalise(*this, system_), done_.loads_compared = false;
      report.held_bodies = guard.hold(*this);
    }
    system_.clear(&scratch);
    done_.contacts_found = false;
    if (!report.outrun) break;
  }
  search.settings.struck.clear();
  return report;
}

// One way of taking the step; there may be another one, from the same origin.
StepReport Simulation::attempt(const StepRequest& request) {
  predict(*this, system_);
  assemble(*this, system_, rows.geometric_stiffness);
  if (leaves_total_form(*this, system_)) set_form(*this, system_, Form::incremental);
  const StepFacts facts = facts_of(*this, system_);
  const StepPlan plan = unibody::plan(scene.solver, traits, facts);
  return solver.solve != nullptr ? solve(*this, system_, plan, facts, request) : newton_step(*this, system_, plan);
}

// A step of the total form whose edges move too far, with the prediction (see attempt()) or with what the solve made of it, is
// taken in the incremental form, which is bounded there. Where the scene asks for the total form, that is not the step that was
// asked for, and so not converged.
StepReport Simulation::take_in_form(const StepRequest& request) {
  StepReport report;
  const auto take = [&] { take_steadily(*this, system_, rows.geometric_stiffness, [&] { report = attempt(request); }); };
  if (!traits.has_centre_constraints || plan(scene.solver, traits).form != Form::total) {
    take();
    return report;
  }
  set_form(*this, system_, Form::total);
  const StepOrigin origin = origin_of(*this);
  take();
  if (!report.outrun && leaves_total_form(*this, system_)) {
    set_form(*this, system_, Form::incremental);
    go_back(*this, system_, origin);
    take();
  }
  report.form_left = scene.solver.form == Form::total && rows.form != Form::total;
  report.converged = report.converged && !report.form_left;
  return report;
}

void Simulation::move_homes(std::span<const int> home) {
  const PhaseClock::Scope scope(clock, Phase::partition);
  HistoriesByRank records = histories_by_rank(*this, home);
  migrate(comm(), world, history.contacts(), home);
  make_constraints();
  take_histories(*this, std::move(records));
  done_.contacts_found = false;
}

namespace {

// The bodies of slots [first, last) that stay, and those that come, in ascending id.
std::vector<Body> changed(const World& world, std::size_t first, std::size_t last, const std::vector<Id>& removed,
                          const std::vector<Body>& added) {
  std::vector<Body> bodies;
  for (std::size_t i = first; i < last; ++i)
    if (!std::ranges::binary_search(removed, world.id[i])) bodies.push_back(world.body(i));
  bodies.insert(bodies.end(), added.begin(), added.end());
  std::ranges::sort(bodies, {}, &Body::id);
  return bodies;
}

}  // namespace

void Simulation::change_bodies(const BodyChanges& changes) {
  std::vector<Id> removed = changes.removed;
  std::ranges::sort(removed);
  const auto is_removed = [&](Id id) { return std::ranges::binary_search(removed, id); };
  for_each_batch_type([&]<class B>(auto, std::type_identity<B>) {
    if constexpr (PairedBatch<B>)
      std::erase_if(history.of<B>(), [&](const auto& pair) { return is_removed(pair.key[0]) || is_removed(pair.key[1]); });
  });
  const std::vector<int> stay(world.homes, halo.rank());
  HistoriesByRank records = histories_by_rank(*this, stay);
  const std::vector<Body> homes = changed(world, 0, world.homes, removed, changes.homes),
                          statics = changed(world, world.first_static(), world.size(), removed, changes.statics);
  world = make_world(homes, statics, scene.has_rotations(), scene.period);
  Multipliers& multipliers = history.contacts();
  Multipliers kept;
  for (std::size_t i = 0; i < multipliers.manifolds.size(); ++i)
    if (!is_removed(multipliers.manifolds[i].id_a) && !is_removed(multipliers.manifolds[i].id_b)) kept.append(multipliers, i);
  multipliers = keep_own(world, kept);
  make_constraints();
  take_histories(*this, std::move(records));
  done_.contacts_found = false;
}

void Simulation::release(std::span<const std::size_t> released) {
  release_joints(*this, released);
  done_.contacts_found = false;
}

std::vector<JointState> Simulation::joint_states() const {
  if (ties.joint_slots.size() != ties.joints.size()) throw std::logic_error("joint_states() before detect()");
  std::vector<JointState> states;
  for (std::size_t i = 0; i < ties.joints.size(); ++i)
    if (ties.joint_input.is_broken(ties.joints[i]))
      states.push_back({.broken = true});
    else
      states.push_back(joint_state(scene.joints[static_cast<std::size_t>(ties.joints[i])], ties.joint_slots[i], world,
                                   history.joints()[i], RankState::step()));
  return states;
}

SolverSettings Simulation::settings_used() const {
  const StepPlan plan = unibody::plan(scene.solver, traits);
  SolverSettings used = scene.solver;
  used.tolerance = plan.tolerance, used.stages = plan.stages, used.margin = plan.margin, used.form = plan.form;
  const bool one_stage = plan.stages == Stages::position;
  if (scene.solver.iterations)  // otherwise each kind of island has its own: the plans of the steps tell them
    used.warm_start = one_stage ? plan.contacts_share : old_share(scene.solver, plan.iterations);
  used.recovery_speed = plan.recovery_speed;
  used.velocity_share = one_stage ? 0 : plan.velocity_share, used.leak = one_stage ? 0 : plan.leak;
  if (scene.solver.level == Level::position) used.recovery_time = plan.recovery_time;
  return used;
}

std::size_t Simulation::bytes() const {
  std::size_t bytes = RankState::bytes();
  for_each_batch(system_.batches, [&](auto, const auto& batch) { bytes += batch.bytes(); });
  return bytes;
}

}  // namespace unibody
