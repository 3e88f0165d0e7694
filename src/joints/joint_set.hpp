// Which joints a rank has to do with, and what they say of contacts.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "collide/contacts.hpp"
#include "joints/joint_batch.hpp"

namespace unibody {

// The joints with a home body here, ascending, and all others of their trees. The bodies of the latter need not be here.
JointList joints_here(std::span<const Joint> joints, const World& world);

// The bodies of other ranks that joints tie to this rank's, ascending; mutual between ranks. `world` has no guests yet.
std::vector<Id> partners(std::span<const Joint> joints, const JointList& list, const World& world);

// The slots of their bodies, all of which are here. A joint is counted where its first body is home, or its second if the first
// is static.
std::vector<JointSlots> joint_slots(std::span<const Joint> joints, const JointList& list, const World& world, Slot nobody);

// The bodies that joints tie and do not let collide, as pairs in ascending order; without those of joints that have broken.
std::vector<std::pair<Id, Id>> jointed_pairs(const JointInput& input);

// Takes away the contacts between these.
void leave_out_jointed(const JointInput& input, Contacts& contacts);

// Gives each joint the smallest colour that none before it has at its moving bodies. is_static(id): no solver moves the body.
// Returns how many colours there are.
std::int32_t colour_joints(std::span<Joint> joints, const std::function<bool(Id)>& is_static);

// Makes trees of the joints: each body that moves is in one at most, and each tree is tied at most once to what does not move. In
// the joints' order: one that would close a loop is in none, nor is a rope or spring. Returns how many trees there are.
std::int32_t plant_trees(std::span<Joint> joints, const std::function<bool(Id)>& is_static);

// One side of a joint where its body is now; of the world where the slot is none of the world's.
JointEnd joint_end(const Joint& joint, std::size_t end, const World& world, Slot slot);

// N m s: the impulse of a joint's force times its arm, and of its torque. Over the step (s), it bounds how fast the torque on
// that body changes with the body's turn (N m): its geometric stiffness.
double turning_stiffness(const Joint& joint, std::size_t end, const JointImpulses& impulses);

// What a joint does now, and how far it is from closed.
struct JointState {
  double drift = 0, turn = 0;  // m, rad: of its own rows, and of what passes its limits
  double coordinate = 0;       // rad or m: angle, offset or length; of a ball with limits its swing
  Vec3 force = Vec3::Zero();   // N, of its own rows on the first body, at its anchor
  Vec3 torque = Vec3::Zero();  // N m, about the anchor
  double limit = 0, motor = 0, friction = 0,
         spring = 0;    // N m or N, along the coordinate; of a ball the length of its limits' torque
  bool broken = false;  // it does nothing any more: all else is 0
};
JointState joint_state(const Joint& joint, const JointSlots& slots, const World& world, const JointImpulses& impulses,
                       double step);

}  // namespace unibody
