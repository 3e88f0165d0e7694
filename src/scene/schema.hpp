// The scene file as a JSON schema (draft 7), for editors that complete and check YAML by one.
#pragma once

#include <string>

namespace unibody {

// The JSON schema of a scene. It has all keys, types and ranges of the sections time, output, solver and materials, and all
// keys of the entries of bodies, cloths, threads, solids and joints. What these may hold depends on each other, and is checked
// by read_scene() alone.
std::string scene_schema();

}  // namespace unibody
