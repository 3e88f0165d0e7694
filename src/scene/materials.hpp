// The section `materials`.
#pragma once

#include "scene/key.hpp"

namespace unibody {

Key materials_key();
void read_materials(const Value& value, Scene& scene);

}  // namespace unibody
