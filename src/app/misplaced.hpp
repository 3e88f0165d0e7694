// Bodies that start where nobody would put them on purpose.
#pragma once

#include <string>
#include <vector>

#include "step/simulation.hpp"

namespace unibody {

// "crate (line 17)"
std::string name_with_line(const Scene& scene, Id id);

// Warnings of dynamic bodies and nodes whose centres start behind a plane, and of a body that is very far from all others.
// Collective; the same on every rank.
std::vector<std::string> misplaced_bodies(const Simulation& simulation);

}  // namespace unibody
