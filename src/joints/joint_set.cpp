#include "joints/joint_set.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <unordered_map>
#include <unordered_set>

#include "joints/joint_types.hpp"

namespace unibody {

namespace {

bool is_home(const World& world, Id id) {
  const Slot slot = id < 0 ? -1 : world.find(id);
  return slot >= 0 && world.is_home(slot);
}

const Joint& at(std::span<const Joint> joints, std::int64_t number) { return joints[static_cast<std::size_t>(number)]; }

}  // namespace

JointList joints_here(std::span<const Joint> joints, const World& world) {
  JointList list;
  const auto touches = [&](const Joint& joint) { return is_home(world, joint.ids[0]) || is_home(world, joint.ids[1]); };
  std::unordered_set<std::int32_t> trees;
  for (const Joint& joint : joints)
    if (joint.tree >= 0 && touches(joint)) trees.insert(joint.tree);
  for (std::size_t j = 0; j < joints.size(); ++j)
    if (touches(joints[j]) || trees.contains(joints[j].tree)) list.push_back(static_cast<std::int64_t>(j));
  return list;
}

std::vector<Id> partners(std::span<const Joint> joints, const JointList& list, const World& world) {
  std::vector<Id> wanted;
  for (const std::int64_t number : list)
    for (const Id id : at(joints, number).ids)
      if (id >= 0 && world.find(id) < 0) wanted.push_back(id);
  std::sort(wanted.begin(), wanted.end());
  wanted.erase(std::unique(wanted.begin(), wanted.end()), wanted.end());
  return wanted;
}

std::vector<JointSlots> joint_slots(std::span<const Joint> joints, const JointList& list, const World& world, Slot nobody) {
  std::vector<JointSlots> slots;
  slots.reserve(list.size());
  for (const std::int64_t number : list) {
    const auto& ids = at(joints, number).ids;
    const Slot a = world.find(ids[0]), b = ids[1] < 0 ? nobody : world.find(ids[1]);
    slots.push_back({a, b, world.is_home(world.is_static(a) ? b : a)});
  }
  return slots;
}

std::vector<std::pair<Id, Id>> jointed_pairs(const JointInput& input) {
  std::vector<std::pair<Id, Id>> pairs;
  for (const std::int64_t number : *input.list) {
    const Joint& joint = at(input.joints, number);
    if (!input.is_broken(number) && !joint.collide && joint.ids[1] >= 0) pairs.push_back(std::minmax(joint.ids[0], joint.ids[1]));
  }
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

void leave_out_jointed(const JointInput& input, Contacts& contacts) {
  const std::vector<std::pair<Id, Id>> pairs = jointed_pairs(input);
  if (pairs.empty()) return;
  leave_out(contacts,
            [&](const Manifold& m) { return std::binary_search(pairs.begin(), pairs.end(), std::pair(m.id_a, m.id_b)); });
}

std::int32_t colour_joints(std::span<Joint> joints, const std::function<bool(Id)>& is_static) {
  std::unordered_map<Id, std::vector<std::int32_t>> taken;
  std::int32_t colours = 0;
  for (Joint& joint : joints) {
    const auto is_taken = [&](std::int32_t colour) {
      return std::any_of(joint.ids.begin(), joint.ids.end(), [&](Id id) {
        const auto found = taken.find(id);
        return found != taken.end() && std::find(found->second.begin(), found->second.end(), colour) != found->second.end();
      });
    };
    for (joint.colour = 0; is_taken(joint.colour);) ++joint.colour;
    for (const Id id : joint.ids)
      if (id >= 0 && !is_static(id)) taken[id].push_back(joint.colour);
    colours = std::max(colours, joint.colour + 1);
  }
  return colours;
}

std::int32_t plant_trees(std::span<Joint> joints, const std::function<bool(Id)>& is_static) {
  std::unordered_map<Id, Id> above;  // of each body one of its tree, towards the one that names it
  std::unordered_set<Id> held;       // names of trees tied to what does not move
  const auto name = [&](Id id) {
    Id top = id;
    while (above.try_emplace(top, top).first->second != top) top = above[top];
    while (above[id] != top) id = std::exchange(above[id], top);
    return top;
  };
  for (Joint& joint : joints) {
    joint.tree = -1;
    if (joint.has_span()) continue;
    std::array<Id, 2> names{-1, -1};
    for (std::size_t e = 0; e < 2; ++e)
      if (joint.ids[e] >= 0 && !is_static(joint.ids[e])) names[e] = name(joint.ids[e]);
    const auto is_held = [&](Id n) { return n < 0 || held.contains(n); };
    if (names[0] == names[1] || (is_held(names[0]) && is_held(names[1]))) continue;
    const bool holds = is_held(names[0]) || is_held(names[1]);
    const Id one = std::max(names[0], names[1]), other = std::min(names[0], names[1]);
    if (other >= 0) above[other] = one;
    if (holds) held.insert(one);
    joint.tree = 0;
  }
  std::unordered_map<Id, std::int32_t> numbers;
  for (Joint& joint : joints) {
    if (joint.tree < 0) continue;
    const Id body = joint.ids[0] >= 0 && !is_static(joint.ids[0]) ? joint.ids[0] : joint.ids[1];
    joint.tree = numbers.emplace(name(body), static_cast<std::int32_t>(numbers.size())).first->second;
  }
  return static_cast<std::int32_t>(numbers.size());
}

JointEnd joint_end(const Joint& joint, std::size_t end, const World& world, Slot slot) {
  const auto s = static_cast<std::size_t>(slot);
  const bool is_body = s < world.size();
  const Quat attitude = is_body ? world.orientation_of(s) : Quat::Identity();
  const Vec3 centre = is_body ? world.position[s] : Vec3(Vec3::Zero());
  return {centre, (attitude * joint.frame[end]).toRotationMatrix(), centre + attitude * joint.anchor[end]};
}

double turning_stiffness(const Joint& joint, std::size_t end, const JointImpulses& impulses) {
  return with_joint_type(own_type(joint.kind), [&]<class T>() {
    double force = 0, torque = 0;
    for (std::size_t k = 0; k < T::rows; ++k) (k + T::angles < T::rows ? force : torque) += impulses.value[k] * impulses.value[k];
    return std::sqrt(force) * joint.anchor[end].norm() + std::sqrt(torque);
  });
}

namespace {

// What passes a ball's limits, and their torque.
void measure_ball(const Joint& joint, const JointEnd& a, const JointEnd& b, const JointImpulses& impulses, double step,
                  JointState& state) {
  JointRows<1> swing, twist;
  Swing::evaluate(a, b, swing), Twist::evaluate(a, b, twist);
  Vec3 torque = Vec3::Zero();
  if (joint.has_cone()) {
    state.turn = std::max(state.turn, swing.value[0] - joint.swing);
    torque += impulses.value[JointImpulses::cone] / step * swing.angular[0];
  }
  if (joint.is_limited()) {
    state.turn = std::max({state.turn, joint.lower - twist.value[0], twist.value[0] - joint.upper});
    torque += impulses.value[JointImpulses::limits] / step * twist.angular[0];
  }
  if (joint.has_cone() || joint.is_limited()) state.coordinate = swing.value[0], state.limit = torque.norm();
}

}  // namespace

JointState joint_state(const Joint& joint, const JointSlots& slots, const World& world, const JointImpulses& impulses,
                       double step) {
  const JointEnd a = joint_end(joint, 0, world, slots.a), b = joint_end(joint, 1, world, slots.b);
  JointState state;
  with_joint_type(own_type(joint.kind), [&]<class T>() {
    JointRows<T::rows> rows;
    T::evaluate(a, b, rows);
    double drift = 0, turn = 0;
    for (std::size_t k = 0; k < T::rows; ++k) {
      const double force = impulses.value[k] / step;
      state.force += force * rows.linear[k];
      state.torque += force * (rows.angular[k] - (a.point - a.centre).cross(rows.linear[k]));
      (k + T::angles < T::rows ? drift : turn) += rows.value[k] * rows.value[k];
    }
    state.drift = std::sqrt(drift), state.turn = std::sqrt(turn);
  });
  if (joint.has_span()) {
    state.coordinate = state.drift, state.drift -= joint.length;
    state.drift = joint.kind == JointKind::rope ? std::max(0.0, state.drift) : std::abs(state.drift);
  }
  if (joint.kind == JointKind::ball) measure_ball(joint, a, b, impulses, step, state);
  if (!joint.has_coordinate()) return state;
  with_joint_type(coordinate_of(joint.kind), [&]<class T>() {
    JointRows<T::rows> rows;
    T::evaluate(a, b, rows);
    state.coordinate = rows.value[0];
    const double passed = std::max({0.0, joint.lower - state.coordinate, state.coordinate - joint.upper});
    double& error = T::angles > 0 ? state.turn : state.drift;
    error = std::max(error, passed);
  });
  state.limit = impulses.value[JointImpulses::limits] / step, state.motor = impulses.value[JointImpulses::motor] / step;
  state.friction = impulses.value[JointImpulses::friction] / step;
  if (joint.is_sprung()) state.spring = impulses.value[JointImpulses::spring] / step;
  return state;
}

}  // namespace unibody
