// The key `collide` of entries of bodies: which other entries their bodies may touch.
#pragma once

#include "scene/key.hpp"
#include "scene/scene.hpp"

namespace unibody {

Key collide_key();

// Reads it of all entries of `bodies`, after the sections that it may name: an entry may name one that comes after it.
void read_touching(const Value& root, Scene& scene);

}  // namespace unibody
