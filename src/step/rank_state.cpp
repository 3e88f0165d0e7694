#include "step/rank_state.hpp"

#include <algorithm>
#include <cmath>

#include "core/capacity.hpp"
#include "core/checked.hpp"
#include "step/liquid.hpp"

namespace unibody {

Drives::Drives(const Scene& scene) : gravity(scene.gravity), drag(scene), pressure(scene) {
  for (const BodyGroup& group : scene.groups) {
    if (group.surface_motion) belts.push_back(&group);
    if (group.motion)
      prescribed.push_back(&group);
    else if (group.load)
      loaded.push_back(&group);
  }
}

Ties::Ties(const Scene& scene)
    : joint_input{scene.joints,   &joints,         &joint_slots, scene.joint_colours, scene.joint_trees > 0, &broken,
                  &pressed_areas, scene.couplings, &couplings,   &coupling_slots,     scene.coupling_colours} {
  joints_break = std::ranges::any_of(scene.joints, [](const Joint& joint) { return joint.bears.any(); });
  if (std::ranges::any_of(scene.joints, [](const Joint& joint) { return joint.area != nullptr; }))
    pressed_areas.assign(scene.joints.size(), 0);
  bodies = tied_bodies(scene, broken);
}

ContactSearch::ContactSearch(const Scene& scene, const Solver& solver, double step) : surfaces(scene.surfaces) {
  for (const BodyGroup& group : scene.groups)
    if (group.friction) friction_axes.push_back({group.first, group.count, group.friction->axis, group.friction->across});
  settings.step = step;
  settings.gravity = scene.gravity;
  settings.planar = scene.planar;
  settings.merge_supports = !solver.sweeps_by_colour;
  settings.friction = scene.friction;
  if (scene.pairs.any(PairValue::restitution)) settings.restitution = scene.pairs[PairValue::restitution];
  if (scene.pairs.any(PairValue::stiction)) {
    settings.stiction = scene.pairs[PairValue::stiction];
    settings.stiction_speed = scene.pairs[PairValue::stiction_speed];
  }
  settings.material_count = scene.materials.size();
  if (scene.touch_rules.any()) settings.touch_rules = &scene.touch_rules;
}

namespace {

SceneTraits traits_of(const Scene& scene) {
  SceneTraits traits;
  traits.frame = scene.time.frame, traits.step = scene.time.frame / scene.time.substeps;
  traits.gravity = scene.gravity_in_time ? scene.gravity_in_time->largest() : scene.gravity.norm();
  traits.has_joints = !scene.joints.empty(), traits.has_attachments = !scene.attachments.empty();
  traits.adheres = scene.pairs.any(PairValue::adhesion) || scene.pairs.any(PairValue::surface_energy);
  if (traits.adheres) traits.adhesion_range = std::ranges::max(scene.pairs[PairValue::adhesion_range]);
  traits.complies = scene.pairs.any(PairValue::stiffness) || scene.pairs.any(PairValue::elastic_modulus);
  traits.is_wet = scene.pairs.any(PairValue::liquid_volume);
  if (traits.is_wet) {
    const double volume = std::ranges::max(scene.pairs[PairValue::liquid_volume]),
                 angle = std::ranges::max(scene.pairs[PairValue::contact_angle]) * M_PI / 180;
    traits.adheres = true, traits.adhesion_range = std::max(traits.adhesion_range, rupture_distance(volume, angle));
  }
  return traits;
}

}  // namespace

RankState::RankState(MPI_Comm over, const Scene& of, PhaseClock& timed_by, bool in_shared_memory)
    : scene(of),
      clock(timed_by),
      solver(find_solver(scene.solver.name)),
      traits(traits_of(scene)),
      when{scene.time.frame / scene.time.substeps},
      drives(scene),
      ties(scene),
      search(scene, solver, traits.step),
      coarse(scene),
      halo(over),
      exchange(halo, timed_by, in_shared_memory ? Exchange::usual_letter : 0) {
  if (scene.solver.form == Form::total) rows.form = Form::total;
}

std::vector<Id> tied_bodies(const Scene& scene, const std::vector<std::uint8_t>& broken) {
  std::vector<Id> tied;
  for (std::size_t j = 0; j < scene.joints.size(); ++j)
    if (broken.empty() || broken[j] == 0) tied.insert(tied.end(), scene.joints[j].ids.begin(), scene.joints[j].ids.end());
  for (const Attachment& attachment : scene.attachments) tied.push_back(attachment.node), tied.push_back(attachment.body);
  std::ranges::sort(tied);
  return tied;
}

bool RankState::is_tied(Id id) const {
  const auto holds = [&](const ConstraintGroup& group) { return id >= group.first && id < group.first + group.count; };
  return std::ranges::binary_search(ties.bodies, id) || std::ranges::any_of(scene.constraint_groups, holds);
}

bool RankState::any_over_ranks(bool here) const {
  int any = here;
  check_mpi(MPI_Allreduce(MPI_IN_PLACE, &any, 1, MPI_INT, MPI_MAX, comm()));
  return any != 0;
}

bool RankState::is_alone() const {
  const auto touches_itself = [](const Surface& s) { return s.self_collision; };
  return scene.groups.size() == 1 && scene.constraint_groups.size() == 1 &&
         std::none_of(scene.surfaces.begin(), scene.surfaces.end(), touches_itself);
}

std::size_t RankState::bytes() const {
  const Multipliers& multipliers = history.contacts();
  std::size_t bytes_of_pairs = bytes_of(multipliers.creeps);
  for_each_batch_type([&]<class B>(auto, std::type_identity<B>) {
    if constexpr (PairedBatch<B>) bytes_of_pairs += bytes_of(history.of<B>());
  });
  return bytes_of(world.id) + world.properties.bytes() + bytes_of(world.position) + bytes_of(world.orientation) +
         bytes_of(world.velocity) + bytes_of(world.angular_velocity) + bytes_of(world.held_orientation) +
         bytes_of(multipliers.manifolds) + bytes_of(multipliers.points) + bytes_of(multipliers.places) +
         bytes_of(contacts.manifolds) + bytes_of(contacts.points) + bytes_of(contacts.surface) + bytes_of(ties.attached) +
         bytes_of_pairs + drives.drag.bytes() + drives.pressure.bytes() + search.surfaces.bytes() + halo.bytes() +
         scratch.bytes() + bytes_of(ties.joints) + bytes_of(history.joints()) + bytes_of(ties.broken) +
         bytes_of(ties.joint_slots) + bytes_of(rows.lasting_counts) + coarse.bytes();
}

}  // namespace unibody
