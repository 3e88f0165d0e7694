// Generators of jointed bodies: chains, trees and ragdolls.
#pragma once

#include "scene/generators.hpp"

namespace unibody {

const Keys& chain_keys();
const Keys& tree_keys();
const Keys& ragdolls_keys();
Generated read_chain(const Value& value, const BodyTemplate& body, const Scene& scene);
Generated read_tree(const Value& value, const BodyTemplate& body, const Scene& scene);
Generated read_ragdolls(const Value& value, const BodyTemplate& body, const Scene& scene);

// Bodies of one group do not touch each other: those of articulated number `i` of an entry whose first body has id `first`.
std::int32_t group_without_contacts(Id first, Id i);

}  // namespace unibody
