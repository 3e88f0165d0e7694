#include "step/breaking.hpp"

#include <algorithm>
#include <set>
#include <utility>

#include "core/checked.hpp"
#include "partition/messages.hpp"

namespace unibody {

namespace {

// Takes the last step into the mean load of a joint that is here, and returns it as force and torque in the joint's axes.
std::pair<Vec3, Vec3> add_load(RankState& state, std::size_t place) {
  const Joint& joint = state.scene.joints[static_cast<std::size_t>(state.ties.joints[place])];
  const JointSlots& slots = state.ties.joint_slots[place];
  JointImpulses& history = state.history.joints()[place];
  const JointState now = joint_state(joint, slots, state.world, history, state.step());
  const Mat3 to_joint = joint_end(joint, 0, state.world, slots.a).axes.transpose();
  const double duration = std::max(joint.bears.duration, Strength::least_steps * state.when.whole_step);
  const double weight = joint.bears.duration > 0 ? state.step() / duration : 1;  // an impulse counts by its time, however short
  Eigen::Map<Vec3> force(history.load.data()), torque(history.load.data() + 3);
  force += weight * (to_joint * now.force - force), torque += weight * (to_joint * now.torque - torque);
  return {force, torque};
}

// Every rank's new breaks, in ascending order of the joints.
std::vector<Break> all_of(MPI_Comm comm, const std::vector<Break>& here) {
  std::vector<Break> all = all_of_ranks<Break>(comm, here);
  std::ranges::sort(all, {}, &Break::joint);
  return all;
}

}  // namespace

void know_breaks(RankState& state) {
  const std::vector<Break>& breaks = state.history.past.breaks;
  if (breaks.size() == state.ties.breaks_known) return;
  state.ties.breaks_known = breaks.size();
  state.ties.broken.assign(breaks.empty() ? 0 : state.scene.joints.size(), 0);
  for (const Break& one : breaks) state.ties.broken[static_cast<std::size_t>(one.joint)] = 1;
  for (std::size_t i = 0; i < state.ties.joints.size(); ++i)
    if (state.ties.joint_input.is_broken(state.ties.joints[i])) state.history.joints()[i] = {};
  state.ties.bodies = tied_bodies(state.scene, state.ties.broken);
}

void break_overloaded(RankState& state) {
  if (!state.ties.joints_break) return;
  std::vector<Break> here;
  for (std::size_t i = 0; i < state.ties.joints.size(); ++i) {
    const std::int64_t number = state.ties.joints[i];
    const Strength& bears = state.scene.joints[static_cast<std::size_t>(number)].bears;
    if (!bears.any() || state.ties.joint_input.is_broken(number)) continue;
    const auto [force, torque] = add_load(state, i);
    if (state.ties.joint_slots[i].counted && load_share(bears, force, torque) > 1)
      here.push_back({number, state.time(), force.norm(), torque.norm()});
  }
  if (!state.any_over_ranks(!here.empty())) return;
  const std::vector<Break> all = all_of(state.comm(), here);
  state.history.past.breaks.insert(state.history.past.breaks.end(), all.begin(), all.end());
}

void release_joints(RankState& state, std::span<const std::size_t> joints) {
  std::vector<Break>& breaks = state.history.past.breaks;
  std::set<std::int64_t> known;
  for (const Break& one : breaks) known.insert(one.joint);
  for (const std::size_t joint : joints)
    if (const auto number = static_cast<std::int64_t>(joint); known.insert(number).second)
      breaks.push_back({number, state.time()});
}

}  // namespace unibody
