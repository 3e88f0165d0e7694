// The section `probes`.
#pragma once

#include "scene/scene.hpp"
#include "scene/value.hpp"

namespace unibody {

// Reads the list `probes` into scene.probes. Bodies and materials are read before.
void read_probes(const Value& list, Scene& scene);

std::vector<std::string> probe_keys();

}  // namespace unibody
