// The section `bonds`: fixed joints that break, between all bodies of some entries that lie next to each other.
#pragma once

#include "scene/key.hpp"
#include "scene/scene.hpp"

namespace unibody {

const Keys& bond_keys();

// Reads the list `bonds` into scene.joints. Its bodies are read before.
void read_bonds(const Value& list, Scene& scene);

}  // namespace unibody
