// The section `probes`.
#pragma once

#include "scene/scene.hpp"
#include "scene/value.hpp"

namespace unibody {

// Reads the list `probes` into scene.probes. Bodies and materials are read before.
void read_probes(const Value& list, Scene& scene);

std::vector<std::string> probe_keys();

// A name that columns of report.csv begin with: letters, digits, - and _. `taken`: those of the other `what`s.
std::string read_column_name(const Value& value, const std::vector<std::string>& taken, const std::string& what);

// The dynamic bodies that the keys `of` and `material` of an entry choose.
ProbedBodies read_probed(const Value& entry, const Scene& scene);

}  // namespace unibody
