// The section `joints`, and what generators of jointed bodies share with it.
#pragma once

#include "scene/body_entry.hpp"

namespace unibody {

// A joint between two bodies where they are at the start, both copies of its axes being `axes` at `point` (world's axes, m).
// Without b: between the body and the world.
Joint joint_between(JointKind kind, const Body& a, const Body* b, const Vec3& point, const Quat& axes);

// Axes whose z is along the unit vector `axis`, and whose x is as near to `second` as can be, or is any where that is none.
Quat joint_axes(const Vec3& axis, const Vec3& second = Vec3::Zero());

// Refuses, as the fault of `value`, a joint at a particle that would have to turn it.
void check_turns(const Value& value, JointKind kind, const Shape& shape);

// The keys of an entry of `joints` of any type; those of one type are in joint_keys.cpp.
const Keys& joint_keys();

// A motor of a hinge or slider.
void read_motor(const Value& value, const Scene& scene, Joint& joint);

void read_joint_behaviour(const KeyedMap& map, const Scene& scene, Joint& joint);

// {type: ball, ...} of a generator whose joints are all alike; the axis (hinge, universal) in the entry's axes.
struct JointTemplate {
  Joint joint;
  Vec3 axis = Vec3::UnitY(), second = Vec3::UnitZ();

  // A joint of this type and behaviour between two bodies, at a point.
  Joint between(const Body& a, const Body* b, const Vec3& point) const;
};
const Keys& joint_template_keys();
JointTemplate read_joint_template(const Value& value, const Scene& scene, const std::vector<JointKind>& kinds);

// Reads the list `joints` into scene.joints. Its bodies are read before.
void read_joints(const Value& list, Scene& scene);

}  // namespace unibody
