// The key `anisotropic_friction` of entries of bodies.
#pragma once

#include <optional>

#include "scene/key.hpp"
#include "scene/scene.hpp"

namespace unibody {

Key anisotropic_friction_key();

// Of an entry; none without the key.
std::optional<AnisotropicFriction> read_anisotropic_friction(const KeyedMap& entry, const Scene& scene);

}  // namespace unibody
