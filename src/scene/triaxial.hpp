// The generator `triaxial`: a cell of plates that press on what is between them.
#pragma once

#include "scene/generators.hpp"

namespace unibody {

const Keys& triaxial_keys();
Generated read_triaxial(const Value& value, const BodyTemplate& body, const Scene& scene);

}  // namespace unibody
