// The section `periodic`.
#pragma once

#include "scene/key.hpp"
#include "scene/scene.hpp"

namespace unibody {

const Keys& periodic_keys();

void read_periodic(const Value& value, Scene& scene);

// Refuses what a periodic scene cannot hold: flexible bodies, planes across a border, and bodies that are longer than half of the
// period, since two images of such a body could touch the same other body.
void check_periodic(const Value& root, const Scene& scene);

}  // namespace unibody
