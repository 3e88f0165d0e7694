// The section `events`.
#pragma once

#include "scene/scene.hpp"
#include "scene/value.hpp"

namespace unibody {

void read_events(const Value& list, Scene& scene);
std::vector<std::string> event_keys();

}  // namespace unibody
