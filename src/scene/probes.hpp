// The section `probes`.
#pragma once

#include "scene/key.hpp"
#include "scene/scene.hpp"

namespace unibody {

// Reads the list `probes` into scene.probes. Bodies and materials are read before.
void read_probes(const Value& list, Scene& scene);

const Keys& probe_keys();

// A name that columns of report.csv begin with: letters, digits, - and _. `taken`: those of the other `what`s.
std::string read_column_name(const Value& value, const std::vector<std::string>& taken, const std::string& what);

// The dynamic bodies that the keys `of` and `material` of an entry choose.
const Keys& probed_keys();
ProbedBodies read_probed(const KeyedMap& entry, const Scene& scene);

}  // namespace unibody
