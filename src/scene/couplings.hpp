// The section `couplings`: joints whose coordinates go with each other.
#pragma once

#include "scene/key.hpp"
#include "scene/scene.hpp"

namespace unibody {

const Keys& coupling_keys();

// Reads the list `couplings` into scene.couplings. Its joints are read before.
void read_couplings(const Value& list, Scene& scene);

}  // namespace unibody
