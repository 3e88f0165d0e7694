// How entries of cloths, threads, solids and joints name a body.
#pragma once

#include <string>

#include "scene/scene.hpp"
#include "scene/value.hpp"

namespace unibody {

// The body that a value names, with its id: an entry of `bodies` by its name or by its place in the list, with a number in
// brackets where it has several. Planes are refused. Entries of cloths and threads cannot be named: they stand behind those of
// bodies. `expected`: what is said where none is named.
Body read_body_name(const Value& value, const Scene& scene, const std::string& expected);

}  // namespace unibody
