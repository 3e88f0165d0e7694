// The key `strength` of joints and bonds.
#pragma once

#include "joints/joint.hpp"
#include "scene/key.hpp"

namespace unibody {

// Of a rope, spring or ball, which bear no torque; of other joints; of bonds.
const Keys& pull_strength_keys();
const Keys& joint_strength_keys();
const Keys& bond_strength_keys();
Key strength_key(KeysOf table);
Key duration_key();

Strength read_strength(const Value& value, const Keys& table);

}  // namespace unibody
