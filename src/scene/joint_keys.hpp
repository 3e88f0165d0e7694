// The keys of joints, which depend on their types.
#pragma once

#include "joints/joint.hpp"
#include "scene/key.hpp"

namespace unibody {

// Of an entry of `joints` of this type.
const Keys& joint_keys_of(JointKind kind);
// Of the map `joint` of a generator whose joints are of this type.
const Keys& joint_template_keys_of(JointKind kind);
// Of a motor that turns, or that slides.
const Keys& motor_keys(bool turns);
const Keys& joint_spring_keys(bool turns);

}  // namespace unibody
