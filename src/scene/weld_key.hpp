// The key `weld` of entries that read a mesh.
#pragma once

#include "scene/value.hpp"

namespace unibody {

// Reads how far nodes are welded in an entry whose mesh has the key `mesh`, as a share of the mesh's extent (meshes/weld.hpp);
// 0: nothing is welded.
double read_weld(const Value& entry, const char* mesh);

}  // namespace unibody
