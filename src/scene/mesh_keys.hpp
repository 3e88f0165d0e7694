// The keys of entries that read a mesh from a file.
#pragma once

#include "scene/key.hpp"

namespace unibody {

namespace keys {

Key scale();  // of a mesh's lengths
Key weld();

}  // namespace keys

// Reads how far nodes are welded in an entry whose mesh has the key `mesh`, as a share of the mesh's extent (meshes/weld.hpp);
// 0: nothing is welded.
double read_weld(const KeyedMap& entry, const char* mesh);

}  // namespace unibody
