// Generators of fixed parts: what bodies fall into.
#pragma once

#include "scene/generators.hpp"

namespace unibody {

const Keys& container_keys();
const Keys& hopper_keys();
Generated read_container(const Value& value, const BodyTemplate& body, const Scene& scene);
Generated read_hopper(const Value& value, const BodyTemplate& body, const Scene& scene);

}  // namespace unibody
