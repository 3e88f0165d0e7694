// The key `shape` of an entry of `bodies`, of a part of a compound and of a mix.
#pragma once

#include "scene/key.hpp"

namespace unibody {

// The map of a shape: one key, its name, with the map that says its size.
const Keys& shape_keys();
Key shape_key(const Without& without);

Shape read_shape(const Value& value, const Scene& scene);

// The normal of a plane's map, {normal: [x, y, z]}.
Vec3 read_plane_normal(const Value& plane, const Scene& scene);

}  // namespace unibody
